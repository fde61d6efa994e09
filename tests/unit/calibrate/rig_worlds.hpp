// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/geometry/rotation.hpp"
#include "synthetic_world.hpp"

namespace raybundle::testing {

inline Rigid3 beside(double x_m, double turn_rad) {
  Rigid3 camera_from_rig;
  camera_from_rig.rotation = Eigen::Quaterniond(rotation_from_vector({0.02, turn_rad, -0.01}));
  camera_from_rig.translation = Eigen::Vector3d(-x_m, 0.004, 0.01);
  return camera_from_rig;
}

inline SyntheticOptions stereo(unsigned seed) {
  SyntheticOptions options;
  options.seed = seed;
  options.frames = 24;
  options.max_off_axis_rad = 0.7;
  SyntheticCamera right;
  right.focal_px = 395.0;
  right.camera_from_rig = beside(0.12, 0.1);
  options.cameras.push_back(right);
  return options;
}

inline SyntheticOptions three_cameras(unsigned seed) {
  SyntheticOptions options = stereo(seed);
  SyntheticCamera third;
  third.camera_from_rig = beside(-0.1, -0.1);
  options.cameras.push_back(third);
  return options;
}

}  // namespace raybundle::testing
