// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// Moves to the lowest optimum that solves from other cameras lead to, with the boards where they are, if it is lower
/// than where the state is. Of many views some tell whether there is one.
///
/// @param single   a problem with one camera
/// @param summary  of the solve that led to the state; of the new one when it moves
/// @return         whether it moved
bool move_to_lower(const CalibrationProblem& single, BundleState& state, const std::vector<Camera>& others,
                   const CalibrateOptions& options, BundleSummary& summary);

/// The same from other states, whose boards have followed their cameras; all views tell.
bool move_to_lower(const CalibrationProblem& single, BundleState& state, std::vector<BundleState> others,
                   const CalibrateOptions& options, BundleSummary& summary);

}  // namespace raybundle
