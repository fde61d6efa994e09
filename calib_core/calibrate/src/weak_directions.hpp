// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "lower_optima.hpp"

namespace raybundle {

/// States from which a solve may lead to another optimum of views that leave a lens loose: its parameters moved along
/// the directions of which the views tell least, some standard deviations either way, and the boards after them.
///
/// @param single  a problem with one camera
/// @param state   its optimum
std::vector<CostedState> states_along_weakest(const CalibrationProblem& single, const BundleState& state, int threads);

/// States of other focal lengths, from half the camera's to twice it, with everything else at its best there: where all
/// boards are held alike, lenses that are far apart may fit nearly as well.
///
/// @param single  a problem with one camera
/// @param state   its optimum
std::vector<CostedState> states_of_other_focals(const CalibrationProblem& single, const BundleState& state,
                                                int threads);

}  // namespace raybundle
