// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/scene/calibration.hpp"
#include "raybundle/uncertainty/corner_evidence.hpp"
#include "raybundle/uncertainty/covariance.hpp"
#include "true_state.hpp"

namespace raybundle::testing {

/// A fisheye that 20 boards were held before, near and far, with noise.
inline SyntheticOptions fisheye_options(unsigned seed) {
  SyntheticOptions options;
  options.noise_px = 0.2;
  options.seed = seed;
  return options;
}

/// Two such cameras, 12 cm apart.
inline SyntheticOptions stereo_options(unsigned seed) {
  SyntheticOptions options = fisheye_options(seed);
  SyntheticCamera right;
  right.camera_from_rig.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.1, 1.0, 0.05).normalized());
  right.camera_from_rig.translation = {-0.12, 0.01, -0.02};
  options.cameras.push_back(right);
  return options;
}

/// What the bundle makes of a world, from the truth as its start.
inline Calibration solved_from_truth(const SyntheticWorld& world) {
  BundleState state = true_state(world);
  solve_bundle(world.problem, state);
  Calibration calibration;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    calibration.cameras.push_back({world.problem.cameras[c].name, state.cameras[c], state.camera_from_rig[c],
                                   corner_evidence(world.problem, state, static_cast<int>(c))});
  }
  calibration.covariance = covariance(reduced_information(world.problem, state)).covariance;
  return calibration;
}

}  // namespace raybundle::testing
