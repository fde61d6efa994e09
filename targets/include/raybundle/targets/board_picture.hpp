// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/targets/board.hpp"

namespace raybundle {

/// A rectangle [m] by its top-left corner and its size.
struct PictureRectangle {
  Eigen::Vector2d corner;
  Eigen::Vector2d size;
};

/// A disc [m].
struct PictureDisc {
  Eigen::Vector2d centre;
  double radius;
};

/// What is printed of a board, seen from its front: x right, y down, (0, 0) the top-left of what is printed [m].
/// Rectangles do not overlap, but touch; no ink lies outside of the size.
struct BoardPicture {
  Eigen::Vector2d size;
  std::vector<PictureRectangle> rectangles;
  std::vector<PictureDisc> discs;
  bool inverted = false;        ///< rectangles and discs are white on a black ground, which fills the size
  Eigen::Vector2d origin;       ///< where the target frame's origin lies
  Eigen::Vector2d x_direction;  ///< of the target frame
  Eigen::Vector2d y_direction;

  /// Where a point of the target frame lies.
  Eigen::Vector2d picture_from_target(const Eigen::Vector3d& x_in_target) const {
    return origin + x_direction * x_in_target.x() + y_direction * x_in_target.y();
  }
};

/// The print of a board.
///
/// Circles have a radius of a quarter of the distance to the nearest neighbour. AprilTags have black squares in the
/// corners between them, as Kalibr's, whatever the width of their border: tag corners are saddles then.
///
/// @throws Error(kBadInput) for a PointSet, which has no print
BoardPicture picture_of(const Board& board);

}  // namespace raybundle
