// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/line.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

namespace raybundle {

Eigen::Matrix<double, 3, 2> across(const Eigen::Vector3d& direction) {
  const double sign = std::copysign(1.0, direction.z());
  const double a = -1.0 / (sign + direction.z());
  const double b = direction.x() * direction.y() * a;
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) << 1.0 + sign * direction.x() * direction.x() * a, sign * b, -sign * direction.x();
  basis.col(1) << b, sign + direction.y() * direction.y() * a, -direction.y();
  return basis;
}

Line3 perturbed(const Line3& line, const Eigen::Vector4d& motion) {
  const Eigen::Matrix<double, 3, 2> basis = across(line.direction);
  return {line.point + basis * motion.head<2>(), (line.direction + basis * motion.tail<2>()).normalized()};
}

Eigen::Vector4d motion_between(const Line3& from, const Line3& to) {
  const Eigen::Matrix<double, 3, 2> basis = across(from.direction);
  const double along = from.direction.dot(to.direction);
  const Eigen::Vector3d crossing = to.at(from.direction.dot(from.point - to.point) / along);
  Eigen::Vector4d motion;
  motion << basis.transpose() * (crossing - from.point), basis.transpose() * to.direction / along;
  return motion;
}

double distance_between(const Line3& line, const Eigen::Vector3d& point) {
  return line.direction.cross(point - line.point).norm();
}

Eigen::Vector3d point_nearest_to(std::span<const Line3> lines) {
  Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();  // for parallel lines
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Line3& line : lines) {
    const Eigen::Matrix3d across_line = Eigen::Matrix3d::Identity() - line.direction * line.direction.transpose();
    normal += across_line;
    right += across_line * line.point;
  }
  return normal.ldlt().solve(right);
}

Line3 line_through(const Eigen::Matrix3Xd& points, const Eigen::ArrayXd& weights, const Eigen::Vector3d& towards) {
  const Eigen::VectorXd w =
      weights.size() > 0 ? Eigen::VectorXd(weights.matrix()) : Eigen::VectorXd::Ones(points.cols());
  const Eigen::Vector3d centroid = points * w / w.sum();
  const Eigen::Matrix3Xd offsets = points.colwise() - centroid;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(offsets * w.asDiagonal() * offsets.transpose());
  const Eigen::Vector3d axis = axes.eigenvectors().col(2);
  return {centroid, axis.dot(towards) < 0.0 ? Eigen::Vector3d(-axis) : axis};
}

}  // namespace raybundle
