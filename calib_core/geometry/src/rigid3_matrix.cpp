// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/rigid3_matrix.hpp"

#include "raybundle/geometry/rotation.hpp"

namespace raybundle {

Eigen::Matrix4d matrix_from_rigid3(const Rigid3& b_from_a) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = b_from_a.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = b_from_a.translation;
  return matrix;
}

std::optional<Rigid3> rigid3_from_matrix(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                                         double rounding) {
  const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm();
  if (!(off < rounding) || !(rotation.determinant() > 0)) return std::nullopt;
  return Rigid3{Eigen::Quaterniond(nearest_rotation(rotation)).normalized(), translation};
}

}  // namespace raybundle
