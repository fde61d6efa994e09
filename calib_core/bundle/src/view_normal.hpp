// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/bundle/view_block.hpp"
#include "view_rows.hpp"

namespace raybundle {

/// The normal equations of one view: [J r]ᵀ[J r], weighted and whitened. A Levenberg-Marquardt step needs no more of
/// its corners than this and the cost.
///
/// Columns: [intrinsics,] the motion of the board in camera axes (MotionMap), [bend_x, bend_y, twist,] residual.
struct ViewNormal {
  Eigen::MatrixXd products;  ///< upper triangle
  double chi2 = 0.0;         ///< exact, of the robust loss: twice the view's cost
};

/// False where linearize_view is.
bool accumulate_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options, ViewNormal& normal);

/// A view's products with the motion of rig_from_target in place of that in camera axes and, behind all other columns,
/// the motion of camera_from_rig; both triangles.
///
/// @param intrinsics  how many columns they have
Eigen::MatrixXd expanded(const Eigen::MatrixXd& products, const MotionMap& map, Eigen::Index intrinsics);

}  // namespace raybundle
