// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "robust_solve.hpp"

namespace raybundle {

std::size_t count_used(const BundleState& state);  ///< corners

/// Whether there are so few corners for each unknown that the fit swallows much of their noise.
bool swallows_noise(const CalibrationProblem& single, const BundleState& state);

/// Decides once more which corners are wrong, now that the lens is another: poses views that were lost. Where the fit
/// swallows much of the noise, a right corner that was left out may also lie far from a prediction that it would have
/// held in place, and a wrong one may hold the camera or its board where right ones seem wrong: takes in corners that
/// were left out, else exchanges one for one that was not where all corners fit better so.
///
/// @param single  a problem with one camera
/// @return        whether the state changed
bool choose_corners_again(const CalibrationProblem& single, const CalibrateOptions& options, SolvedState& solved);

}  // namespace raybundle
