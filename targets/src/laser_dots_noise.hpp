// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <opencv2/core/mat.hpp>

namespace raybundle {

/// A pixel's noise: read noise and quantisation, and shot noise in proportion to the grey value.
struct GreyNoise {
  double read_variance = 1.0;  ///< [grey²]
  double shot_variance = 0.0;  ///< [grey² per grey]

  double variance(double grey) const { return read_variance + shot_variance * std::max(0.0, grey); }
};

/// Noise from one image's own statistics, or from the difference of a pair.
///
/// @param on, off      CV_32F; `off` may be empty
/// @param scale        of `off` to the background of `on`
/// @param full_scale   blocks that come near to this grey value do not count
GreyNoise noise_of(const cv::Mat& on, const cv::Mat& off, double scale, double full_scale);

/// How much brighter the background of `on` is than `off`, from the brighter half of their pixels. Robust against the
/// spots, which are a minority.
double background_scale(const cv::Mat& on, const cv::Mat& off, double black, double full_scale);

}  // namespace raybundle
