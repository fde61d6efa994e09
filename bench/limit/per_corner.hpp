// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"

namespace raybundle::limit {

/// The same problem as limit::solve in what one writes first with Ceres: one automatically differentiated residual for
/// each corner. Same start; Ceres's tolerances, so tight that solve_bundle may end before.
BundleSummary solve_per_corner(const CalibrationProblem& problem, BundleState state);

}  // namespace raybundle::limit
