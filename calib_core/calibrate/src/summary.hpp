// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// Writes the solved state into the result: calibration, poses in use, residual and fate of every observation, and the
/// summary of each camera. Leaves set_aside, covariance and stages to the caller.
void fill_result(const CalibrationProblem& problem, const BundleState& state, CalibrationResult& result);

}  // namespace raybundle
