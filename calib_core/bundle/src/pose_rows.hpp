// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "layout.hpp"
#include "raybundle/bundle/view_block.hpp"
#include "unknowns.hpp"

namespace raybundle {

/// What the views of one board pose tell of the free parameters when the pose may follow them freely.
struct PoseEquations {
  Eigen::MatrixXd left;  ///< [J r]ᵀ[J r] by the parameters and the residual, the pose eliminated; upper triangle
  double chi2 = 0.0;     ///< rᵀr before that
  int residuals = 0;
  int directions = 0;  ///< of the pose's six, that the corners see
};

/// @param views  of one pose
/// @return       index into problem.views of a view with a corner that its camera does not project; -1: there is none
int eliminate_pose(const std::vector<ViewData>& views, const Unknowns& unknowns, const Layout& layout,
                   double robust_scale_sigma, PoseEquations& equations);

}  // namespace raybundle
