// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>

#include "laser_dots_noise.hpp"
#include "raybundle/targets/laser_dots.hpp"

namespace raybundle {

/// What the spots are measured in. All images are CV_32F; those of the background are empty without a laser-off image.
struct DotImages {
  cv::Mat on;
  cv::Mat background;     ///< the laser-off image, scaled
  cv::Mat signal;         ///< on - background, or on
  cv::Mat variance;       ///< [grey²] of `signal` where there is no spot
  GreyNoise noise;        ///< of `on`
  double black = 0;       ///< grey value without light
  double full_scale = 0;  ///< grey value above which a pixel may be saturated

  bool pair() const { return !background.empty(); }
};

DotImages dot_images(const cv::Mat& on, const cv::Mat* off, const DotOptions& options);

}  // namespace raybundle
