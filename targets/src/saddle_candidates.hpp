// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raybundle {

/// A place that looks like a chessboard corner, good to about half a pixel.
struct SaddleCandidate {
  Eigen::Vector2f pixel;
  /// Unit vectors along its four edges, clockwise; the sectors between 0 and 1 and between 2 and 3 are bright.
  std::array<Eigen::Vector2f, 4> rays;
  float contrast = 0;  ///< grey values
};

/// Saddles of the blurred image's surface around which dark and bright change four times.
///
/// @param blurred  8-bit single channel, lightly blurred
/// @return         strongest first
std::vector<SaddleCandidate> saddle_candidates(const cv::Mat& blurred);

}  // namespace raybundle
