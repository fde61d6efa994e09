// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// What holds the cameras of a rig together.
struct LinkingFrames {
  int shared = 0;   ///< frames in which several cameras saw a board; several boards count one by one
  int linking = 0;  ///< of them, those in which two saw it in one place
};

LinkingFrames linking_frames(const CalibrationProblem& problem, const CalibrationResult& result);

}  // namespace raybundle
