// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "raybundle/synthetic/rig.hpp"

namespace raybundle {

/// A convex piece of the board's plane [m].
struct Quad {
  std::array<Eigen::Vector2d, 4> corners;  ///< in turn

  Eigen::Vector2d low() const { return corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]).cwiseMin(corners[3]); }
  Eigen::Vector2d high() const { return corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]).cwiseMax(corners[3]); }
  double area() const;
};

double area_in_box(const Quad& quad, const BoardPrint::Box& box);
double area_in_disc(const Quad& quad, const BoardPrint::Disc& disc);

/// How much of a piece of the board is ink. Boxes and discs are kept in a grid, so that only near ones are looked at.
class PrintCoverage {
 public:
  explicit PrintCoverage(const BoardPrint& print);

  /// Area of the quad that is ink [m²].
  double ink_area(const Quad& quad) const;

  /// Whether the quad, which lies on the sheet, is all paper (0) or all ink (1); -1 where that is not obvious.
  int uniform(const Quad& quad) const;

  const BoardPrint::Box& sheet() const { return print_.sheet; }

 private:
  /// Calls visit(shape) once for each shape whose surroundings meet the rectangle, until it returns false.
  template <typename Visit>
  void for_each_near(const Eigen::Vector2d& low, const Eigen::Vector2d& high, Visit&& visit) const;

  void insert(int shape, const Eigen::Vector2d& low, const Eigen::Vector2d& high);
  Eigen::Array2i cell_of(const Eigen::Vector2d& place) const;

  BoardPrint print_;
  Eigen::Vector2d cell_size_;
  std::vector<std::vector<int>> cells_;  ///< shapes: boxes, then discs
};

}  // namespace raybundle
