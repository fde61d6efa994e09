// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"

namespace raybundle::bench {

/// What most peers do: start values, then least squares over all corners. calibrate() besides tells outliers, looks for
/// other optima, bends the board and gives sigmas.
///
/// @param problem  gets the priors that its lenses have
/// @param threads  change the time, never the bits
/// @return         cameras and rig; pairs and rigs are solved camera by camera first, then together
BundleState plain_solve(CalibrationProblem& problem, int threads);

}  // namespace raybundle::bench
