// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// Decides anew, under the cameras as they are, in which frames the cameras saw the board in one place. A view that did
/// not gets a board pose of its own: it keeps its say about its camera but not about the rig. Views that fit again
/// are tied again.
///
/// @param untied  replaced: the views with a board pose of their own and why
/// @return        whether a tie changed
bool review_ties(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                 std::vector<SetAside>& untied);

}  // namespace raybundle
