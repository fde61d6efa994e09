// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// Weighs what is known of some lenses before any corner is seen, by the state's noise and field. Each coefficient of
/// the radial profile of a rational lens is zero, with a sigma of 1, or of what moves the outermost corner by its own
/// radius where that is more: lenses from the rectilinear to the equidistant one (atan(r) / r) have coefficients of
/// about 1 at most. Of other models what their definition says (kExpected): xi of a unified lens is 1 with a sigma
/// of 1.
///
/// Without it, numerator and denominator leave a nearly common factor open, whose pole the noise puts just beyond the
/// outermost corner, and xi runs away with the focal length: for a gain in the cost of less than 1, a lens that is
/// none, far from the truth, at the end of a valley along which a solve creeps. What the corners determine it does not
/// touch; nothing, where they are exact.
///
/// Noise and field are rounded, so that a solve from elsewhere weighs alike.
///
/// @param problem  its lens_priors are replaced; a camera without views has none, nor a rational
///                 lens whose corners show no field
/// @return         whether they changed
bool weigh_lens_priors(CalibrationProblem& problem, const BundleState& state);

/// Whether a parameter of a problem's blocks has the prior of its lens, and not one by a rule.
bool has_lens_prior(const CalibrationProblem& problem, const Parameter& parameter);

/// Those of the problem's lens_priors that no rule overrides.
std::vector<ParameterRule> lens_priors_in_force(const CalibrationProblem& problem);

}  // namespace raybundle
