// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/types.hpp>
#include <vector>

#include "laser_dots_images.hpp"

namespace raybundle {

/// A place that a spot's filter responds to.
struct SpotPeak {
  cv::Point pixel;
  float significance = 0;  ///< response over its own sigma
  float amplitude = 0;     ///< [grey] of a spot that explains the response
};

/// Local maxima of a spot's matched filter without mean, in raster order.
std::vector<SpotPeak> spot_peaks(const DotImages& images, double sigma_px, double least_significance);

/// Robust size of the filter's response within a region over what the noise explains: above 1 the noise has been
/// underestimated, or is correlated between pixels. Spots are a minority; print is none only in a pair's difference.
///
/// @param in_region  CV_8U mask of the image's size
double noise_excess(const DotImages& images, double sigma_px, const cv::Mat& in_region);

}  // namespace raybundle
