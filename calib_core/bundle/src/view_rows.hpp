// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "raybundle/bundle/view_block.hpp"

namespace raybundle {

/// Derivatives of the u or v pixel coordinate of a view's corners, one row for each corner, weighted and whitened.
///
/// Columns: focal length, principal point, shape parameters of the model, three of a rotation and three of a
/// translation in camera axes about the board's origin, [bend_x, bend_y, twist,] residual. u does not depend on fy and
/// cy, nor v on fx and cx, so both have the same few columns. The two poses' columns are linear in the six (MotionMap).
struct ViewRows {
  Eigen::MatrixXd u, v;  ///< padded with zero rows for gram()
  int corners = 0;
  int model_shape_size = 0;
  bool with_shape = false;
  double robust_chi2 = 0.0;    ///< sum of ρ(s) over the corners, s the squared whitened distance
  double weighted_chi2 = 0.0;  ///< sum of s ρ'(s): of the squared residual columns

  int motion() const { return 2 + model_shape_size; }  ///< first of its six columns
  int columns() const { return motion() + 6 + (with_shape ? 3 : 0) + 1; }
  int unknowns() const { return columns() + 1; }  ///< fx fy cx cy, ... instead of focal and principal; without residual

  /// Column among the unknowns, then the residual, for a column of u (axis 0) or v (axis 1).
  static int full_column(int column, int axis) { return column < 2 ? 2 * column + axis : column + 2; }
};

/// Camera and board rotations, and how the motions of the two poses move the board in camera axes.
struct MotionMap {
  Eigen::Matrix3d camera_from_rig;     ///< rotation
  Eigen::Matrix3d camera_from_target;  ///< rotation
  Eigen::Vector3d arm;                 ///< the board's origin as seen from the rig's, in camera axes [m]
  Eigen::Vector3d translation;         ///< of camera_from_target [m]

  explicit MotionMap(const ViewPoint& point);

  /// Derivative of the motion in camera axes by that of rig_from_target: a motion (w, t) turns the board by R w about
  /// its origin and shifts it by R t, R the rotation of camera_from_rig.
  Eigen::Matrix<double, 6, 6> wrt_rig_from_target() const;

  /// The same by the motion of camera_from_rig: turns by w, but about the rig's origin, and shifts by t.
  Eigen::Matrix<double, 6, 6> wrt_camera_from_rig() const;
};

/// Sum of ρ(s) over a view's corners; nothing where linearize_view is false.
std::optional<double> view_chi2(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options);

/// False where linearize_view is.
bool fill_rows(const ViewData& view, const ViewPoint& point, const MotionMap& map, const ViewBlockOptions& options,
               ViewRows& rows);

}  // namespace raybundle
