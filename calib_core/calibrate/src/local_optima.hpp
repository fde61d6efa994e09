// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// Leaves the optima of a solved camera that lie beside the right one: boards held by their mirrored pose, and lenses
/// whose model has a twin that fits better. The state changes only to one of lower cost.
///
/// @param single   a problem with one camera
/// @param reasons  aligned with problem.views
/// @param solved   how the state came about
/// @return         of the last solve: `solved` where nothing was better
BundleSummary leave_local_optima(const CalibrationProblem& single, BundleState& state, const CalibrateOptions& options,
                                 std::vector<std::string>& reasons, const BundleSummary& solved);

}  // namespace raybundle
