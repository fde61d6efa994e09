// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/bundle/view_block.hpp"

namespace raybundle {

/// The normal equations of one view: [J r]ᵀ[J r], weighted and whitened. A Levenberg-Marquardt step needs no more of
/// its corners than this and the cost.
///
/// Columns: intrinsics, the motion of the board in camera axes (MotionMap), [bend_x, bend_y, twist,] residual.
struct ViewNormal {
  Eigen::MatrixXd products;  ///< upper triangle
  double chi2 = 0.0;         ///< exact, of the robust loss: twice the view's cost
};

/// False where linearize_view is.
bool accumulate_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options, ViewNormal& normal);

}  // namespace raybundle
