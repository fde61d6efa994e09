// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// The laser's wavelength as dots on boards show it.
struct WavelengthEstimate {
  double scale = 1.0;  ///< Grating::wavelength_scale
  double sigma = 0.0;  ///< from how the dots scatter about their beams
  double was = 1.0;    ///< the calibration's own scale
  int dots = 0;        ///< that were used

  double change() const { return scale / was - 1.0; }
};

/// One scale for all beams, so that the dots on boards of known place fit best; cameras and boards are held.
///
/// @param calibration      with a laser that has a grating
/// @param problem          views with dots; their labels are not used
/// @param rig_from_target  aligned with problem.views; empty: the board's place is not known
/// @return                 nothing with fewer than ten dots near their beams, or when they do not come to rest
std::optional<WavelengthEstimate> estimate_wavelength(const Calibration& calibration, const CalibrationProblem& problem,
                                                      const std::vector<std::optional<Rigid3>>& rig_from_target);

}  // namespace raybundle
