// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "robust_solve.hpp"

namespace raybundle {

/// A state and its cost, as in BundleSummary.
struct CostedState {
  BundleState state;
  double cost = 0.0;
};

/// Moves to the lowest optimum that solves from other cameras lead to, with the boards where they are, if it is lower
/// than where the state is. Of many views some tell whether there is one.
///
/// @param single  a problem with one camera
/// @return        whether it moved
bool move_to_lower(const CalibrationProblem& single, const std::vector<Camera>& others, const CalibrateOptions& options,
                   SolvedState& solved);

/// The same from other states, whose boards have followed their cameras; all views tell.
///
/// @param others  where solves begin; then where they have come to after some steps, without those that broke down
///                or spoil the lens
bool move_to_lower(const CalibrationProblem& single, std::vector<CostedState>& others, const CalibrateOptions& options,
                   SolvedState& solved);

}  // namespace raybundle
