// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/uncertainty/verdict.hpp"

namespace raybundle {

/// Whether the images of a camera were exposed row by row while something moved; nothing when no view tells.
///
/// @param camera  index of CalibrationProblem::cameras
std::optional<Finding> shutter_finding(const CalibrationProblem& problem, const CalibrationResult& result, int camera);

/// Whether the cameras of a rig exposed together; nothing for a single camera.
std::optional<Finding> sync_finding(const CalibrationProblem& problem, const CalibrationResult& result);

/// Whether the frames repeat each other; nothing when none do.
std::optional<Finding> repetition_finding(const CalibrationProblem& problem, const CalibrationResult& result);

}  // namespace raybundle
