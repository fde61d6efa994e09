// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// Depths, along z of the camera, between which a dot may lie.
struct DepthInterval {
  double nearest_m = 0.15;
  double farthest_m = 1.5;
};

/// The ambiguity map: a beam's dot moves along a curve in the image as its depth changes; where the curves of two beams
/// come closer than the tolerance the label has to come from elsewhere (neighbours, order, uniqueness).
BeamAmbiguity beam_ambiguity(const RigCamera& camera, const LaserPattern& pattern, double tolerance_px,
                             const DepthInterval& depths = {});

/// The turn that leaves most dots with a single candidate, in steps of a degree; the pattern needs its grating.
TurnedPattern best_turn(const RigCamera& camera, const LaserPattern& pattern, double tolerance_px,
                        const DepthInterval& depths = {});

}  // namespace raybundle
