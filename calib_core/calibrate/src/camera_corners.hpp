// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// Corners of a camera's posed views, where the state puts them.
struct CameraCorners {
  std::vector<Eigen::Vector3d> rays;    ///< unit vectors in the camera
  std::vector<Eigen::Vector2d> pixels;  ///< where they were measured, aligned with rays
};

/// Those that are in use.
CameraCorners used_corners(const CalibrationProblem& problem, const BundleState& state, int camera);

/// Those that are not known to be wrong: in use, or not projected by the lens as it is.
CameraCorners right_corners(const CalibrationProblem& problem, const BundleState& state, int camera);

/// Angle off the axis of the farthest of the corners that are not known to be wrong; 0 when there is none.
double farthest_corner_rad(const CalibrationProblem& problem, const BundleState& state, int camera);

}  // namespace raybundle
