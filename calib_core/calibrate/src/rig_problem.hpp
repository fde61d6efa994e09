// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cameras_alone.hpp"
#include "subproblem.hpp"

namespace raybundle {

/// The cameras that could be calibrated alone, as one problem, and what they have told alone.
struct RigProblem {
  std::vector<int> cameras;  ///< of the whole problem
  Subproblem sub;
  std::size_t own_rules = 0;                                        ///< the others hold coefficients that were given up
  std::vector<double> sigmas_alone;                                 ///< aligned with cameras, as is the next
  std::vector<double> sigma_scales;                                 ///< as in CameraSummary
  std::vector<std::optional<Rigid3>> camera_from_target, mirrored;  ///< here and below: aligned with the views
  std::vector<std::vector<ObservationFate>> fates;
  std::vector<std::string> reasons;
};

/// Takes the views' observations out of the whole problem.
///
/// @throws Error(kNotEnoughData) when no camera could be calibrated
RigProblem rig_problem(CalibrationProblem& whole, const CamerasAlone& alone);

}  // namespace raybundle
