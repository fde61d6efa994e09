// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "robust_solve.hpp"
#include "ties.hpp"

namespace raybundle {

/// Which frames tie the cameras, and by which rule.
struct Ties {
  TieRule rule;
  TieReview review;
};

struct JointSolve {
  SolvedState solved;
  Ties ties;
  bool shape_estimated = false;
};

/// One bundle for everything: which frames tie the cameras, which corners are outliers, and whether the boards are bent
/// are settled along with the solve.
///
/// @param sigmas_alone  aligned with problem.cameras: robust_sigmas of each by itself [sigmas of a corner]
/// @param start         cameras as they are alone, rig and boards as they start; its summary tells how a single camera's
///                      solve alone ended
/// @throws Error(kSolveFailed); Error(kBadInput) when boards of other sizes have come together; Error(kNotEnoughData)
///         when the frames do not tie the cameras
JointSolve solve_jointly(const CalibrationProblem& problem, const CalibrateOptions& options,
                         const std::vector<double>& sigmas_alone, SolvedState start);

}  // namespace raybundle
