// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// How a parameter of a camera changes from the first half of the frames to the second.
struct Drift {
  std::string name;     ///< as in Covariance
  double change = 0.0;  ///< in the parameter's unit
  double sigma = 0.0;   ///< of the change
};

/// Focal length and principal point of each camera, by one step of Gauss-Newton from the common solution to what each
/// half of the frames, in their order, would say alone. A lens that was touched, or warmed up, shows.
///
/// @return  empty when a half does not determine the parameters
std::vector<Drift> drift_between_halves(const CalibrationProblem& problem, const CalibrationResult& result);

}  // namespace raybundle
