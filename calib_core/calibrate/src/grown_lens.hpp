// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "local_optima.hpp"

namespace raybundle {

/// Indices of the parameters of a lens's shape, but for the first, that an ordinary lens has at zero, in the order of
/// the model.
std::vector<int> higher_coefficients(ModelId model);

/// Solves for a lens with a denominator once more from a simple shape, and keeps what fits all corners better: from the
/// lens whose higher coefficients are zero, which are let go one after the other; corners that were left out
/// of posed views come back as the rule of outliers allows.
///
/// Numerator and denominator may have a nearly common factor, and a solve that has all coefficients at once ends at one
/// of many optima, or bends the lens to where it leaves out the corners of the rim that would have held it. On the way
/// from the simple lens each coefficient has little left to explain, and no corner is beyond the lens.
///
/// Looks only where that may have happened: where the projection is known loosely, where there are few corners for each
/// unknown, or where several corners of a view that were left out lie beyond all that are in use.
///
/// @param single   a problem with one camera
/// @param optimum  its solved state; its projection_sigma_px is not changed
/// @return         whether the state changed
bool grow_lens(const CalibrationProblem& single, const CalibrateOptions& options, CameraOptimum& optimum);

}  // namespace raybundle
