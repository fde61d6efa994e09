// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "marker.hpp"
#include "raybundle/targets/detect.hpp"

namespace raybundle {

/// Finds a ChArUco board: markers first, then the corners between them by local prediction and saddle refinement.
///
/// With the wrong layout or polarity there are no observations, and the hint names the setting to change.
///
/// @param gray  8-bit single channel
Detection detect_charuco(const cv::Mat& gray, const Charuco& board);

/// refine_predicted() for a ChArUco board.
std::vector<Observation> refine_predicted_charuco(const cv::Mat& gray, const Charuco& board,
                                                  const std::vector<Observation>& predicted);

/// Corners of the board's markers, in the order of their ids, for the layout that `board` names.
MarkerLayout charuco_layout(const Charuco& board);

/// Says why the markers of an image make no board: another layout, polarity, size or dictionary. Empty when no
/// explanation fits.
///
/// @param upright  the image with the polarity that `board` names
/// @param search   what was found in it
std::string charuco_hint(const cv::Mat& upright, const Charuco& board, const MarkerSearch& search);

}  // namespace raybundle
