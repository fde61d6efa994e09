// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// Depths, along z of the camera, between which a dot may lie.
struct DepthInterval {
  double nearest_m = 0.15;
  double farthest_m = 1.5;
};

/// Two beams whose dots can lie at the same place of the image, so that one dot alone does not tell them apart.
struct AmbiguousBeams {
  int first = 0;  ///< LaserGrid::index; first < second
  int second = 0;
  double distance_px = 0.0;  ///< between their curves in the image, at the closest
};

/// How well single dots tell the beams of a pattern apart in one camera's image.
struct BeamAmbiguity {
  double tolerance_px = 0.0;            ///< distance up to which a dot may belong to a beam's curve
  std::vector<AmbiguousBeams> pairs;    ///< sorted; those within the tolerance somewhere
  double single_candidate_share = 1.0;  ///< of the dots, over beams and inverse depths: only one beam is in question
};

/// The ambiguity map: a beam's dot moves along a curve in the image as its depth changes; where the curves of two beams
/// come closer than the tolerance the label has to come from elsewhere (neighbours, order, uniqueness).
BeamAmbiguity beam_ambiguity(const RigCamera& camera, const LaserPattern& pattern, double tolerance_px,
                             const DepthInterval& depths = {});

/// A turn of the lattice about its own axis and the ambiguity that it would have.
struct TurnedPattern {
  double turn_rad = 0.0;  ///< from how the pattern is now, in (-45°, 45°]
  double single_candidate_share = 0.0;
};

/// The turn that leaves most dots with a single candidate, in steps of a degree; the pattern needs its grating.
TurnedPattern best_turn(const RigCamera& camera, const LaserPattern& pattern, double tolerance_px,
                        const DepthInterval& depths = {});

}  // namespace raybundle
