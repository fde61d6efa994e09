// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <vector>

#include "raybundle/camera/camera.hpp"

namespace raybundle {

/// A pixel and the unit ray that lands on it.
struct PixelRay {
  Eigen::Vector2d pixel;  ///< [px]
  Eigen::Vector3d ray;    ///< in the camera
};

/// Pixels on a grid over the image, borders included, that have a ray.
///
/// @param max_angle_rad  rays farther off the axis are left out
/// @param samples_per_side  grid points along each side, at least 2
std::vector<PixelRay> rays_over_image(const Camera& camera, double max_angle_rad = std::numbers::pi,
                                      int samples_per_side = 65);

/// How far a camera's image is from another's of the same rays.
struct CameraDifference {
  double rms_px = 0.0;
  double largest_px = 0.0;
  Eigen::Vector2d largest_at = Eigen::Vector2d::Zero();  ///< pixel of the camera that is compared with
  double lost_share = 0.0;                               ///< of the rays: those that the other does not project
};

/// Projects rays by another camera and compares the pixels. Rays that it does not project count in lost_share only.
CameraDifference difference_over(const std::vector<PixelRay>& rays, const Camera& other);

}  // namespace raybundle
