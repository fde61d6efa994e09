// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// Which dots lie on their board: where the camera's ray meets it amid its points, or no farther beyond the outermost
/// than one and a half times what these are apart. All dots of views that are not used are off.
///
/// @return  aligned with problem.views and their dots
std::vector<std::vector<bool>> dots_on_boards(const CalibrationProblem& problem, const BundleState& state);

/// The problem with the dots that are kept.
CalibrationProblem with_dots(const CalibrationProblem& problem, const std::vector<std::vector<bool>>& kept);

/// Values of the kept dots as those of all dots; `other` for the rest.
std::vector<std::vector<int>> for_all_dots(const std::vector<std::vector<int>>& of_kept,
                                           const std::vector<std::vector<bool>>& kept, int other);

}  // namespace raybundle
