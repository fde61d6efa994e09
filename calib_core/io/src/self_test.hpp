// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// A point that a camera sees, and where: who reads a calibration file checks model, parameters and transform by it.
struct TestedPoint {
  Eigen::Vector3d x_in_rig;       ///< [m]
  Eigen::Vector3d ray_in_camera;  ///< unit
  Eigen::Vector2d pixel;
};

/// Points at one metre on the rays of a 3 x 3 grid of pixels; those whose pixel hangs on rounding are left out.
std::vector<TestedPoint> self_tests_of(const RigCamera& camera);

}  // namespace raybundle
