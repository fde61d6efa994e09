// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// A line in space. `direction` has unit length; `point` is any point on the line.
struct Line3 {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();

  Eigen::Vector3d at(double distance) const { return point + distance * direction; }
};

/// The same line in another frame.
inline Line3 operator*(const Rigid3& b_from_a, const Line3& line_in_a) {
  return {b_from_a * line_in_a.point, b_from_a.rotation * line_in_a.direction};
}

/// Two unit vectors across a direction: with it they are a right-handed frame (first, second, direction). They depend
/// on the direction only and turn smoothly with it, except across z = 0.
///
/// Source: Duff et al. 2017, Building an Orthonormal Basis, Revisited.
Eigen::Matrix<double, 3, 2> across(const Eigen::Vector3d& direction);

/// Moves a line: its point by motion[0..1] [m], its direction by the slopes motion[2..3] [rad, small], both along
/// across(direction). These four are the coordinates of a line in the bundle and in every covariance of one.
Line3 perturbed(const Line3& line, const Eigen::Vector4d& motion);

/// The motion that takes `from` to the same set of points as `to`: its point is the one in the plane through from.point
/// across from.direction. The lines must not be at right angles.
Eigen::Vector4d motion_between(const Line3& from, const Line3& to);

/// Shortest distance from a point to the line [m].
double distance_between(const Line3& line, const Eigen::Vector3d& point);

/// The point whose squared distances to the lines have the least sum; of parallel lines the one nearest to the origin.
Eigen::Vector3d point_nearest_to(std::span<const Line3> lines);

/// The line through points that has the least squared distance to them: centroid and principal axis. Its direction
/// points along `towards`.
///
/// @param points   3×N, N >= 2, not all the same
/// @param weights  N, > 0, or empty for equal ones
Line3 line_through(const Eigen::Matrix3Xd& points, const Eigen::ArrayXd& weights, const Eigen::Vector3d& towards);

}  // namespace raybundle
