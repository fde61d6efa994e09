// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "true_state.hpp"

namespace raybundle::testing {

/// The state moved away from where it is: focal lengths by some percent, centres by some pixels, poses by some degrees
/// and centimetres, each a little differently, boards made flat.
inline BundleState disturbed(BundleState state) {
  double phase = 0.0;
  const auto wobble = [&] { return std::sin(phase += 1.7); };
  const auto move = [&](Rigid3& pose) {
    Eigen::Matrix<double, 6, 1> motion;
    for (int i = 0; i < 6; ++i) motion[i] = 0.02 * wobble();
    pose = perturbed(pose, motion);
  };
  for (Camera& camera : state.cameras) {
    camera.parameters[0] *= 1.0 + 0.04 * wobble();
    camera.parameters[1] *= 1.0 + 0.04 * wobble();
    camera.parameters[2] += 4.0 * wobble();
    camera.parameters[3] += 4.0 * wobble();
  }
  for (std::size_t c = 1; c < state.camera_from_rig.size(); ++c) move(state.camera_from_rig[c]);
  for (BoardPose& pose : state.poses) move(pose.rig_from_target);
  std::ranges::fill(state.shapes, BoardShape{});
  return state;
}

/// Largest difference of the parameters, relative to their size or to one.
inline double largest_difference(const BundleState& a, const BundleState& b) {
  double largest = 0.0;
  const auto add = [&](double x, double y) {
    largest = std::max(largest, std::abs(x - y) / std::max(1.0, std::abs(y)));
  };
  const auto add_pose = [&](const Rigid3& x, const Rigid3& y) {
    const Eigen::Matrix<double, 6, 1> motion = motion_between(y, x);
    for (int i = 0; i < 6; ++i) add(motion[i], 0.0);
  };
  for (std::size_t c = 0; c < a.cameras.size(); ++c) {
    for (int k = 0; k < a.cameras[c].parameters.size(); ++k)
      add(a.cameras[c].parameters[k], b.cameras[c].parameters[k]);
    add_pose(a.camera_from_rig[c], b.camera_from_rig[c]);
  }
  for (std::size_t p = 0; p < a.poses.size(); ++p) add_pose(a.poses[p].rig_from_target, b.poses[p].rig_from_target);
  for (std::size_t t = 0; t < a.shapes.size(); ++t) {
    add(a.shapes[t].bend_x_m, b.shapes[t].bend_x_m);
    add(a.shapes[t].bend_y_m, b.shapes[t].bend_y_m);
    add(a.shapes[t].twist_m, b.shapes[t].twist_m);
  }
  return largest;
}

inline SyntheticCamera rig_camera(const std::string& model, double angle_rad, double x_m) {
  SyntheticCamera camera;
  camera.model = model;
  camera.camera_from_rig.rotation = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(0.1, 1, 0.05).normalized());
  camera.camera_from_rig.translation = Eigen::Vector3d(x_m, 0.01, -0.02);
  return camera;
}

/// Two fisheye cameras beside each other, the usual stereo head.
inline SyntheticOptions stereo_options() {
  SyntheticOptions options;
  options.cameras = {SyntheticCamera{}, rig_camera("kannala_brandt", 0.05, -0.12)};
  return options;
}

}  // namespace raybundle::testing
