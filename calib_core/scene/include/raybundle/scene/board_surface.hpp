// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "raybundle/geometry/line.hpp"
#include "raybundle/scene/target.hpp"

namespace raybundle {

/// The printed surface of a flat target, bent by a BoardShape: z as a function of (x, y) in the target's frame, on and
/// beyond the area of its points.
class BoardSurface {
 public:
  /// @throws Error(kBadInput) when the target is not flat
  explicit BoardSurface(const Target& target);

  /// Height above the plane z = 0 is basis(x, y) · (bend_x, bend_y, twist).
  Eigen::Vector3d basis(double x, double y) const;

  double height(double x, double y, const BoardShape& shape) const;

  /// Not of unit length: (-dz/dx, -dz/dy, 1).
  Eigen::Vector3d normal(double x, double y, const BoardShape& shape) const;

  /// Where a line meets the surface; nothing when it runs along it. Newton's method from the plane, so for boards that
  /// are bent by much less than they are wide.
  std::optional<Eigen::Vector3d> crossing(const Line3& line_in_target, const BoardShape& shape) const;

  /// Whether a place is within the rectangle of the target's points, widened by `margin_m`.
  bool covers(const Eigen::Vector3d& x_in_target, double margin_m = 0.0) const;

 private:
  Eigen::Array2d centre_ = Eigen::Array2d::Zero();
  Eigen::Array2d half_ = Eigen::Array2d::Ones();  ///< half the extent of the points [m]
};

}  // namespace raybundle
