// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// Whether a rule of the problem gives a parameter a prior.
bool has_priors(const CalibrationProblem& problem);

/// What corners are off by, in units of their stated sigmas; 1 when there are too few to tell.
double corner_noise(const CalibrationProblem& problem, const CalibrationResult& result);

/// The problem with the priors of its rules as a solve has to take them that counts corners by their stated sigmas and
/// multiplies all sigmas by the noise in the end: there each prior has the sigma that it was given.
///
/// @param noise  as of corner_noise
CalibrationProblem with_priors_for(const CalibrationProblem& problem, double noise);

/// The problem with priors that leave the corners no say in place of rules that keep their values: what the corners say of
/// them is found as of any value that is kept.
CalibrationProblem with_overruling_priors_kept(const CalibrationProblem& problem, const CalibrationResult& result);

/// Names priors that contradict what the corners say, by more than both sigmas together bear.
///
/// @param problem  as it was solved
/// @param result   with covariance and residuals
std::vector<std::string> contradicted_priors(const CalibrationProblem& problem, const BundleState& state,
                                             const CalibrationResult& result);

}  // namespace raybundle
