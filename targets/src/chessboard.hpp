// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "raybundle/scene/observation.hpp"
#include "raybundle/targets/board.hpp"
#include "raybundle/targets/detect.hpp"

namespace raybundle {

/// Finds a chessboard, full or with corners missing, at any distortion; follows curved rows by local prediction.
///
/// Id 0 is never mirrored: x right, y down, looking at the printed side. Where columns + rows is odd, the square
/// outside of corner 0 is black; otherwise the print looks the same when turned, and corner 0 is the one of the
/// candidates that lies furthest to the top left of the image. Hand in the complement of the image of an inverted
/// board.
///
/// A board that shows one column or one row more than asked for, or both, gives the asked part of it next to its own
/// corner 0, with a hint. Any other size gives nothing, and a hint when the lattice seen is clean.
///
/// @param gray  8-bit single channel
/// @return      no observations when there is no board or its place on the lattice is ambiguous
Detection detect_chessboard(const cv::Mat& gray, const Chessboard& board);

/// Refines chessboard corners near their predicted pixels; the window follows the distance to predicted neighbours.
/// Accepts a corner only when a saddle of the expected orientation and polarity lies within a fraction of a square.
///
/// @param predicted  pixel of each corner, by id; corners out of the image may be left out
/// @return           accepted corners, sorted by id
std::vector<Observation> refine_predicted_chessboard(const cv::Mat& gray, const Chessboard& board,
                                                     const std::vector<Observation>& predicted);

}  // namespace raybundle
