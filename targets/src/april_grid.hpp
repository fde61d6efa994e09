// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "raybundle/targets/detect.hpp"

namespace raybundle {

/// Finds a grid of AprilTags. The first tags come from a contour search; the others are predicted from their
/// neighbours, refined and read, so that tags which touch the black corner squares, or lie near the rim of a fisheye,
/// count too.
///
/// @param gray  8-bit single channel
Detection detect_april_grid(const cv::Mat& gray, const AprilGrid& board);

/// refine_predicted() for a grid of AprilTags: a tag counts when its code reads as the predicted one.
std::vector<Observation> refine_predicted_april_grid(const cv::Mat& gray, const AprilGrid& board,
                                                     const std::vector<Observation>& predicted);

}  // namespace raybundle
