// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "raybundle/scene/observation.hpp"
#include "raybundle/targets/board.hpp"

namespace raybundle {

/// What was found of a board in one image. No board is a normal answer: no observations, and a hint when there is one.
struct Detection {
  std::vector<Observation> observations;  ///< sorted by point id, ids do not repeat
  std::string hint;       ///< when something is odd: "17 markers seen but no corner: try legacy = true", else empty
  std::string seen_size;  ///< of a chessboard that is there but does not fit the one asked for: 9x6; else empty
};

/// Finds a board, full or partial, at any distortion. Deterministic; safe to call from several threads.
///
/// @param gray  8-bit or 16-bit single channel
Detection detect(const Board& board, const cv::Mat& gray);

/// Refines the points of a board near where a first calibration predicts them, so that corners which the detector
/// missed count too (TartanCalib's idea). Accepts a point only when its pattern is really there.
///
/// @param predicted  pixel of each board point, by point id; the points' neighbourhood tells scale and orientation
/// @return           accepted points with sub-pixel position and sigma
std::vector<Observation> refine_predicted(const Board& board, const cv::Mat& gray,
                                          const std::vector<Observation>& predicted);

}  // namespace raybundle
