// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// A board whose points lie so far apart, or so close, that its unit is probably a mistake; empty for any other.
std::string unit_warning(const Target& target);

/// What a person should know of the data behind a result that nothing in the result itself can show: boards in the
/// wrong unit, images of one camera that were given as another's, too, left and right that lie the other way round,
/// frames whose images are exchanged, cameras that few views stand for, and views that were set aside although no other
/// one reaches as far. calibrate() adds them to its own.
std::vector<std::string> data_warnings(const CalibrationProblem& problem, const CalibrationResult& result);

}  // namespace raybundle
