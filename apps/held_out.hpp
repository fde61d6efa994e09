// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle::apps {

/// Observations that a calibration has not seen, as a problem in which everything is held but the poses of the boards.
struct HeldOut {
  CalibrationProblem problem;         ///< boards that the calibration knows are bent as it found them
  std::vector<std::string> warnings;  ///< what is odd about the boards
};

/// @throws Error(kBadInput) for a camera that is not in the calibration, or has images of another size
HeldOut held_out(const CalibrationFile& file, const CalibrationProblem& observed);

}  // namespace raybundle::apps
