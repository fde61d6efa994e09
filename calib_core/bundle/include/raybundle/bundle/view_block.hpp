// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// The points of a board that are used in a view, or in several that use the same; arrays have one row for each of them.
struct BoardPoints {
  Eigen::MatrixX3d x_in_target;  ///< on the ideal board [m]
  Eigen::ArrayXd nearness;       ///< what a translation counts: 1, but 0 for points that are infinitely far
  Eigen::MatrixX3d shape_basis;  ///< as shape_basis(target)

  /// @param basis  shape_basis(target)
  /// @param used   which of target.points
  BoardPoints(const Target& target, const std::vector<Eigen::Vector3d>& basis, const std::vector<int>& used);
};

/// The used observations of one board view, gathered once; arrays have one row for each of them.
struct ViewData {
  int view = 0;  ///< index into problem.views
  int camera = 0;
  int target = 0;
  int pose = 0;
  ModelId model;
  std::shared_ptr<const BoardPoints> points;
  Eigen::MatrixX2d pixel;        ///< measured [px]
  Eigen::ArrayXd inverse_sigma;  ///< [1/px]
};

/// One entry for each view that has a pose and at least one used observation, in the order of problem.views.
std::vector<ViewData> used_views(const CalibrationProblem& problem, const BundleState& state);

/// The observations of a single view that are marked kUsed, and what they are of; the indices are not set.
ViewData view_data(const Target& target, const TargetView& view, const std::vector<ObservationFate>& fates);

/// The unknowns that one view depends on.
struct ViewPoint {
  const double* intrinsics = nullptr;
  Rigid3 camera_from_rig;
  Rigid3 rig_from_target;
  Eigen::Vector3d shape = Eigen::Vector3d::Zero();  ///< bend_x, bend_y, twist [m]
};

struct ViewBlockOptions {
  bool with_shape = false;          ///< fill ViewBlock::wrt_shape
  double robust_scale_sigma = 0.0;  ///< as BundleOptions
  bool lens_fixed = false;          ///< leave the intrinsics out of products
};

/// The whitened residual (projected minus measured) of one view, two rows for each corner, and its Jacobians at a
/// ViewPoint.
///
/// With a robust loss the rows carry the square root of the weight ρ'. The last row has no Jacobian: it makes up the
/// cost, so that half the squared residual is the view's exact (robust) cost. For a concave ρ that is never less than
/// what the other rows hold, because ρ(s) >= s ρ'(s).
struct ViewBlock {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::VectorXd residual;
  Rows wrt_intrinsics;
  Rows wrt_camera_from_rig;  ///< columns as the motion of perturbed()
  Rows wrt_rig_from_target;  ///< columns as the motion of perturbed()
  Rows wrt_shape;            ///< bend_x, bend_y, twist; empty without
};

/// False when the model does not project one of the corners, or a focal length is not positive; `block` is then not
/// meaningful. No corner ever gets a made-up residual.
bool linearize_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options, ViewBlock& block);

/// The products [J r]ᵀ[J r] of the rows that linearize_view() makes, without the rows; both triangles. The row that a
/// robust loss adds for its cost does not count.
///
/// Columns: intrinsics, motion of rig_from_target, [bend_x, bend_y, twist,] residual, motion of camera_from_rig.
///
/// @return  false where linearize_view() is
bool multiply_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options,
                   Eigen::MatrixXd& products);

}  // namespace raybundle
