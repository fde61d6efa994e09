// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// What is to be kept needs a value: the search would keep what it happened to start with.
///
/// @throws Error(kBadInput) also for rules that match nothing
void require_values(const CalibrationProblem& problem);

/// Whether rules keep parameters at values.
bool keeps_values(const CalibrationProblem& problem);

/// The problem without the rules that do.
CalibrationProblem without_kept_values(const CalibrationProblem& problem);

/// A sentence when the corners do not bear out the values at which parameters are kept: residuals are larger than
/// without, by far more than a coefficient that is left out for good reasons costs, or the corners say another value, by
/// many sigmas.
///
/// @param freed, of_freed  without_kept_values() and what it gave
std::vector<std::string> contradictions(const CalibrationProblem& problem, const CalibrationResult& result,
                                        const CalibrationProblem& freed, const CalibrationResult& of_freed);

}  // namespace raybundle
