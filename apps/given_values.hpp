// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "raybundle/scene/problem.hpp"

namespace raybundle::apps {

/// Start values from a calibration, which also are the values of what rules keep without giving one. Warns of cameras that
/// the calibration does not have, which start from their images; where the first one is such, all places do.
///
/// @throws Error(kBadInput) when it has none of the cameras, for another model or image size, and when a rule keeps what it
///         does not say
void take_start(const std::string& path, CalibrationProblem& problem);

/// Warns of rules that could as well be left out: others override them, or they speak of the camera that defines the
/// rig.
void warn_of_void_rules(const CalibrationProblem& problem);

}  // namespace raybundle::apps
