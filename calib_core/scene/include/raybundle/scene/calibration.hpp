// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/scene/laser.hpp"
#include "raybundle/scene/target.hpp"

namespace raybundle {

/// A calibrated camera in its place on the rig.
struct RigCamera {
  std::string name;
  Camera camera;
  Rigid3 camera_from_rig;
};

/// A board as the solve found it.
struct CalibratedTarget {
  Target target;
  BoardShape shape;
};

/// Joint covariance of named parameters. Names are those that ParameterRule patterns match: left.fx,
/// right.camera_from_rig.rotation_x, ... (rotation as in perturbed(), radians; translation metres), board.bend_x.
struct Covariance {
  std::vector<std::string> names;
  Eigen::MatrixXd matrix;  ///< names × names

  /// Standard deviation by name; 0 for a parameter that was not estimated.
  double sigma(const std::string& name) const;
};

/// What is saved: intrinsics, extrinsics, board shapes and how well they are known.
struct Calibration {
  std::vector<RigCamera> cameras;  ///< the first one defines the rig frame
  std::vector<CalibratedTarget> targets;
  Covariance covariance;
  std::optional<LaserPattern> laser;
};

/// The camera of that name. Throws Error(kBadInput) that lists the names there are.
const RigCamera& camera_named(const Calibration& calibration, const std::string& name);

}  // namespace raybundle
