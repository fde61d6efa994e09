// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "raybundle/scene/problem.hpp"

namespace raybundle::apps {

/// Start values from a calibration, which also are the values of what rules keep without giving one.
///
/// @throws Error(kBadInput) for a camera of another name, model or image size
void take_start(const std::string& path, CalibrationProblem& problem);

/// Warns of rules that could as well be left out: others override them, or they speak of the camera that defines the
/// rig.
void warn_of_void_rules(const CalibrationProblem& problem);

}  // namespace raybundle::apps
