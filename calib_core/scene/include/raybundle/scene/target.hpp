// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace raybundle {

/// A point printed on a board, or a landmark.
struct TargetPoint {
  int id = 0;
  Eigen::Vector3d x_in_target = Eigen::Vector3d::Zero();  ///< [m], on the ideal board
  bool infinitely_far = false;  ///< a landmark of which only the direction counts: x_in_target
};

/// How a flat board is bent: at (x, y) in [-1, 1]² over the board its surface lies at
/// z = bend_x (1 - x²) + bend_y (1 - y²) + twist x y. Sags and twist are heights [m]; all zero is a plane.
struct BoardShape {
  double bend_x_m = 0.0;
  double bend_y_m = 0.0;
  double twist_m = 0.0;

  bool operator==(const BoardShape&) const = default;
  Eigen::Vector3d sags() const { return {bend_x_m, bend_y_m, twist_m}; }
  static BoardShape from_sags(const Eigen::Vector3d& sags) { return {sags.x(), sags.y(), sags.z()}; }
};

/// A relabelling under which the printed board looks the same, as ids[i] -> image of points[i].id; a board turned by
/// 180° whose squares have the same colours is the usual one. Cameras may label such a board differently.
struct TargetSymmetry {
  std::vector<int> ids;  ///< as many as Target::points
};

/// A rigid board. `points` is sorted by id without repetition; z = 0 for flat boards.
struct Target {
  std::string name;
  std::vector<TargetPoint> points;
  std::vector<TargetSymmetry> symmetries;  ///< without the identity

  /// The point with that id; nullptr when the board has none.
  const TargetPoint* find(int id) const {
    if (id >= 0 && id < static_cast<int>(points.size()) && points[id].id == id) return &points[id];  // ids 0..n-1
    return find_among_others(id);
  }

  /// True when all points have z = 0, so that the board can have a BoardShape.
  bool flat() const;

 private:
  const TargetPoint* find_among_others(int id) const;
};

/// The part of a bent surface that does not depend on the shape: height = shape_basis · (bend_x, bend_y, twist).
/// Zero for targets that are not flat.
///
/// @return  one 3-vector for each of target.points, same order
std::vector<Eigen::Vector3d> shape_basis(const Target& target);

/// Points on the bent surface, in the order of target.points [m].
std::vector<Eigen::Vector3d> points_on_surface(const Target& target, const BoardShape& shape);

}  // namespace raybundle
