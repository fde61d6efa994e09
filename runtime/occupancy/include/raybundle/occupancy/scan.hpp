// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "raybundle/device/state.hpp"

namespace raybundle {

/// Where the ray of a beam or of a pixel ends. Vehicle frame: x forward to the dashboard, y left, z up.
struct ScenePoint {
  int ray = 0;                                             ///< of the beam or pixel, the same in every frame
  Eigen::Vector3d x_in_vehicle = Eigen::Vector3d::Zero();  ///< [m]
  double sigma_m = 0.0;                                    ///< standard deviation along the ray
};

/// What a sensor measured in one frame. All rays leave from one viewpoint: the emitter's exit, or the left camera.
struct Scan {
  Eigen::Vector3d viewpoint_in_vehicle = Eigen::Vector3d::Zero();  ///< [m]
  std::span<const ScenePoint> points;                              ///< at most one for a ray
  int rays = 0;                                                    ///< that the sensor has; ray < rays
  State state = State::kOk;                                        ///< of the sensor
};

}  // namespace raybundle
