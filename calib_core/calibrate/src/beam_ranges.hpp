// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// Where the used dots of a beam lie along it.
struct BeamRanges {
  std::vector<double> ranges_m;  ///< from the beam's point nearest to the rig's origin, ascending

  int count() const { return static_cast<int>(ranges_m.size()); }
  double nearest_m() const { return ranges_m.empty() ? 0.0 : ranges_m.front(); }
  double farthest_m() const { return ranges_m.empty() ? 0.0 : ranges_m.back(); }
  double depth_m() const { return farthest_m() - nearest_m(); }
};

/// By LaserGrid::index.
std::vector<BeamRanges> ranges_of_beams(const CalibrationProblem& problem, const BundleState& state);

}  // namespace raybundle
