// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// States from which a solve may lead to another optimum of views that leave a lens loose: its parameters moved along
/// the directions of which the views tell least, some standard deviations either way, and the boards after them.
///
/// @param single  a problem with one camera
/// @param state   its optimum
std::vector<BundleState> states_along_weakest(const CalibrationProblem& single, const BundleState& state, int threads);

}  // namespace raybundle
