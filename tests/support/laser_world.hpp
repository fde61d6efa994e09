// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "synthetic_world.hpp"

namespace raybundle::testing {

/// A dot projector beside the first camera.
struct LaserOptions {
  LaserGrid grid{.rows = 11, .columns = 11};
  double turn_rad = 0.21;        ///< of the lattice about its axis
  double gap_m = 0.06;           ///< along the rig's x
  double offset_rad = 0.0008;    ///< each beam's own deviation from the grating model, standard deviation
  double noise_px = 0.1;         ///< of the dots; 0: exact, with sigma 0.1
  double missed_fraction = 0;    ///< dots that were not found
  double spurious_fraction = 0;  ///< dots that no beam made, in proportion to those that are there
  bool labelled = false;
  double brightest_factor = 1.0;  ///< of the middle beam
  std::vector<int> missing = {};  ///< beams that are not there
  unsigned seed = 1;
};

/// What is true of the dots.
struct LaserTruth {
  std::vector<std::optional<Line3>> lines;    ///< by beam
  std::vector<std::vector<int>> beam_of_dot;  ///< aligned with problem.views and their dots
};

/// Adds dots to all views of a world, and the laser to its problem.
LaserTruth add_laser(SyntheticWorld& world, const LaserOptions& options);

/// The problem with noise on every corner and dot, of that standard deviation in u and in v.
CalibrationProblem with_noise(CalibrationProblem exact, double sigma_px, unsigned seed);

/// A camera of 130° × 100° and boards from 25 cm to 1.2 m: enough range for the beams.
SyntheticOptions laser_rig_options(int frames, unsigned seed);

}  // namespace raybundle::testing
