// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "ties.hpp"

namespace raybundle {

struct JointSolve {
  BundleSummary summary;
  TieReview ties;
  bool shape_estimated = false;
};

/// One bundle for everything: which frames tie the cameras, which corners are outliers, and whether the boards are bent
/// are settled along with the solve.
///
/// @param state         cameras as they are alone, rig and boards as they start; solved in place
/// @param sigmas_alone  aligned with problem.cameras: robust_sigmas of each by itself [sigmas of a corner]
/// @param reasons       aligned with problem.views; why a view is set aside
/// @param solved        of a single camera: how its solve alone ended, where the state comes from
/// @throws Error(kSolveFailed); Error(kNotEnoughData) when boards of other sizes have come together, or the frames do
///         not tie the cameras
JointSolve solve_jointly(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                         const std::vector<double>& sigmas_alone, std::vector<std::string>& reasons,
                         const BundleSummary& solved = {});

}  // namespace raybundle
