// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// A candidate pose and how well it explains the rays.
struct TargetPose {
  Rigid3 camera_from_target;
  double rms_rad = 0.0;  ///< angle between measured rays and board points, root mean square
};

/// Pose of a target from one view; for planar boards both candidates of the planar ambiguity. Rays may point anywhere
/// on the sphere. Refined by Gauss-Newton on the angles.
///
/// @param points_in_target  N [m], N >= 4, not collinear; planar or not
/// @param rays_in_camera    N unit vectors, same order
/// @return                  best first; empty when the points are collinear or nothing fits in front of the rays
std::vector<TargetPose> target_pose(std::span<const Eigen::Vector3d> points_in_target,
                                    std::span<const Eigen::Vector3d> rays_in_camera);

/// The same when some of the pairs are wrong: LO-RANSAC over target_pose, seeded by `seed` alone.
///
/// @param threshold_rad  angle up to which a pair counts as right
std::optional<TargetPose> robust_target_pose(std::span<const Eigen::Vector3d> points_in_target,
                                             std::span<const Eigen::Vector3d> rays_in_camera, double threshold_rad,
                                             unsigned seed = 0);

}  // namespace raybundle
