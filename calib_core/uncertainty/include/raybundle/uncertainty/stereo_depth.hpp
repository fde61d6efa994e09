// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// How well a stereo point's depth, along z of the first of two cameras, is known.
struct StereoDepth {
  double sigma_m = std::numeric_limits<double>::quiet_NaN();   ///< by the calibration; NaN: not seen by both cameras
  double per_px_m = std::numeric_limits<double>::quiet_NaN();  ///< for matching errors of 1 px in each coordinate
};

/// Depth of the point that the first camera sees at a pixel, triangulated by least squares in both images while all
/// parameters of both cameras are as uncertain, together, as the covariance says. Nothing is taken out: the depth
/// counts from the camera's own frame.
///
/// @param covariance  Calibration::covariance, or another one of the same parameters
/// @param depth_m     of the point, along z of the first camera, > 0
StereoDepth stereo_depth(const RigCamera& first, const RigCamera& second, const Covariance& covariance,
                         const Eigen::Vector2d& pixel_in_first, double depth_m);

}  // namespace raybundle
