// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"
#include "raybundle/targets/board.hpp"

namespace raybundle::apps {

/// Says that the tags of a grid look smaller or larger, against the pitch at which they repeat, than its measures have
/// it: spacing is easily measured wrongly, and where the paper is overexposed it eats into the black. No other unknown of
/// a solve takes that up, so that it stays in the residuals, where each view tells it.
///
/// @param target  index into problem.targets of that grid
/// @return  the warning, with the measures that would fit; empty when the views do not agree on any, or when it would
///          explain less than a fifth of the residuals' squares
std::string tag_size_warning(const AprilGrid& grid, int target, const CalibrationProblem& problem,
                             const CalibrationResult& result);

}  // namespace raybundle::apps
