// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "raybundle/targets/detect.hpp"

namespace raybundle {

/// Finds a grid of circles, black on white or white on black, at any distortion.
///
/// A circle's centre does not project to the centre of its image: perspective and lens pull the ellipse aside. The
/// shift follows from how the neighbouring circles bend the map from board to image, and is taken off; no lens model is
/// needed for that. The board's x axis points as far to the image's right as its symmetry allows.
///
/// @param gray  8-bit single channel
Detection detect_circles(const cv::Mat& gray, const Circles& board);
Detection detect_circles(const cv::Mat& gray, const AsymmetricCircles& board);

/// refine_predicted() for grids of circles.
std::vector<Observation> refine_predicted_circles(const cv::Mat& gray, const Circles& board,
                                                  const std::vector<Observation>& predicted);
std::vector<Observation> refine_predicted_circles(const cv::Mat& gray, const AsymmetricCircles& board,
                                                  const std::vector<Observation>& predicted);

}  // namespace raybundle
