// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/uncertainty/coverage.hpp"
#include "raybundle/uncertainty/verdict.hpp"

namespace raybundle {

/// What the data of a result are good for and what they lack, camera by camera, then board by board.
///
/// @param seen  aligned with the calibration's cameras
std::vector<Finding> findings(const CalibrationProblem& problem, const CalibrationResult& result,
                              const std::vector<CameraCoverage>& seen);

}  // namespace raybundle
