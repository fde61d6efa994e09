// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// The frame in which a set of points lies as flat as it can: centred, principal axes, unit spread.
struct PrincipalFrame {
  Eigen::Matrix3d local_from_target = Eigen::Matrix3d::Identity();  ///< rotation
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();                 ///< [m], in the target
  Eigen::Vector3d spread = Eigen::Vector3d::Zero();  ///< [m], standard deviation along the axes, largest first

  bool collinear() const { return !(spread[1] > 1e-6 * spread[0]); }
  bool planar() const { return spread[2] <= 1e-6 * spread[0]; }
  Eigen::Vector3d local(const Eigen::Vector3d& x_in_target) const {
    return local_from_target * (x_in_target - centre) / spread[0];
  }
};

PrincipalFrame principal_frame(std::span<const Eigen::Vector3d> points_in_target);

/// Pose of a (nearly) planar target from rays anywhere on the sphere, linear: the homography H of its plane with
/// (I - r rᵀ) H (x, y, 1)ᵀ = 0, then the nearest rotation. N >= 4.
std::optional<Rigid3> linear_planar_pose(std::span<const Eigen::Vector3d> points_in_target,
                                         std::span<const Eigen::Vector3d> rays_in_camera, const PrincipalFrame& frame);

/// Pose of a target that is not planar, linear: the 3×4 projection P with (I - r rᵀ) P (x, y, z, 1)ᵀ = 0. N >= 6.
std::optional<Rigid3> linear_spatial_pose(std::span<const Eigen::Vector3d> points_in_target,
                                          std::span<const Eigen::Vector3d> rays_in_camera, const PrincipalFrame& frame);

/// The pose that looks the same under weak perspective: depths along the line of sight mirrored at the target's centre.
Rigid3 mirrored_pose(const Rigid3& camera_from_target, const PrincipalFrame& frame);

/// All poses that put three points onto three rays exactly, at most four.
/// Source: Haralick et al., "Review and analysis of solutions of the three point perspective pose estimation problem",
/// IJCV 1994, Grunert's solution, eqs. 8 to 9; unit vectors anywhere on the sphere, so that no ray is special.
std::vector<Rigid3> three_point_poses(const Eigen::Vector3d* points_in_target, const Eigen::Vector3d* rays_in_camera);

}  // namespace raybundle
