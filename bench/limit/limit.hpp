// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"

namespace raybundle::limit {

/// Bundle adjustment of one Kannala-Brandt camera and one flat board, every corner seen or not, and nothing else: no
/// other model, rule, prior, robust loss, second camera or thread. What the arithmetic costs, to measure solve_bundle
/// against; same start, same steps, same tolerances.
BundleSummary solve(const CalibrationProblem& problem, BundleState& state);

}  // namespace raybundle::limit
