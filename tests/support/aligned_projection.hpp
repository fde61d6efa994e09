// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "synthetic_world.hpp"

namespace raybundle::testing {

/// A board corner as the true camera sees it.
struct TrueCorner {
  Eigen::Vector3d x_in_camera;
  Eigen::Vector2d pixel;  ///< exact [px]
};

/// The corners that a camera of a world observed.
std::vector<TrueCorner> true_corners(const SyntheticWorld& world, int camera);

/// The motion of the corners after which another camera sees them where the true one does, by least squares over all
/// of them: what no image tells from a change of the camera. Gauss-Newton with numeric derivatives.
Rigid3 aligning_motion(const std::vector<TrueCorner>& corners, const Camera& camera);

/// Where a camera sees a point of the surroundings that the motion has aligned.
///
/// @param range_m  of the point along the unit ray; infinite ones are turned only
std::optional<Eigen::Vector2d> aligned_projection(const Camera& camera, const Rigid3& motion,
                                                  const Eigen::Vector3d& ray, double range_m);

}  // namespace raybundle::testing
