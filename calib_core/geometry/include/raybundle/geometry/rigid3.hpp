// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace raybundle {

/// Rigid transform `b_from_a`: x_in_b = rotation * x_in_a + translation. The quaternion has unit norm.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< [m]

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_a) const { return rotation * x_in_a + translation; }

  /// c_from_a = c_from_b * b_from_a.
  Rigid3 operator*(const Rigid3& b_from_a) const {
    return {(rotation * b_from_a.rotation).normalized(), rotation * b_from_a.translation + translation};
  }

  /// a_from_b of b_from_a.
  Rigid3 inverse() const {
    const Eigen::Quaterniond a_from_b = rotation.conjugate();
    return {a_from_b, -(a_from_b * translation)};
  }
};

/// Moves a transform by a small motion in the target frame: rotation exp(motion[0..2]) on the left, translation added.
/// This is the one perturbation of poses in the bundle and in every pose covariance.
///
/// @param motion  rotation vector [rad], then translation [m]
Rigid3 perturbed(const Rigid3& b_from_a, const Eigen::Matrix<double, 6, 1>& motion);

/// The motion that takes `from` to `to`: perturbed(from, motion_between(from, to)) == to.
Eigen::Matrix<double, 6, 1> motion_between(const Rigid3& from, const Rigid3& to);

/// Angle of the relative rotation [rad], in [0, pi].
double angle_between(const Rigid3& a, const Rigid3& b);

}  // namespace raybundle
