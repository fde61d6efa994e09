// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "raybundle/synthetic/render.hpp"

namespace raybundle::testing {

inline constexpr double kRadian = std::numbers::pi / 180;

inline Camera small_camera(const char* model, double focal_px) {
  Camera camera = start_camera(*model_named(model), {200, 160}, focal_px);
  camera.parameters[2] += 1.37;
  camera.parameters[3] -= 0.81;
  return camera;
}

// A chessboard in front of one camera of 12 bits.
inline SimulatedRig board_rig(const Camera& camera) {
  SimulatedRig rig;
  SimulatedCamera seen;
  seen.name = "camera";
  seen.camera = camera;
  seen.sensor.bits = 12;
  rig.cameras.push_back(seen);
  rig.board = simulated_chessboard(7, 5, 0.03);
  rig.board.print.sheet.low.array() -= 0.03;
  rig.board.print.sheet.high.array() += 0.03;
  return rig;
}

// Board centre at a place, tilted and rolled.
inline Rigid3 pose_at(const Eigen::Vector3d& place, const Eigen::Vector3d& turned_deg) {
  Rigid3 pose;
  pose.rotation = Eigen::AngleAxisd(turned_deg.z() * kRadian, Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(turned_deg.y() * kRadian, Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(turned_deg.x() * kRadian, Eigen::Vector3d::UnitX());
  pose.translation = place - pose.rotation * Eigen::Vector3d(0.09, 0.06, 0);
  return pose;
}

}  // namespace raybundle::testing
