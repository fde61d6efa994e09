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

/// What the corners in use say of a camera beside its parameters: where in its image they were, and which motion of the
/// surroundings they could not have told from a change of its parameters.
struct CornerEvidence {
  int columns = 0;  ///< cells of equal size that the image is divided into
  int rows = 0;
  std::vector<int> corners;  ///< in each cell, row by row
  /// The motion of everything before the camera (rotation [rad] about its centre, then translation [m], its axes) that
  /// best undoes, over the corners, what a unit of each parameter does to the image; columns as Camera::parameters.
  Eigen::Matrix<double, 6, Eigen::Dynamic> implied_motion;

  /// Index of the cell that holds a pixel; nothing outside of the image.
  std::optional<int> cell(ImageSize size, const Eigen::Vector2d& pixel) const;
  /// Whether corners were seen in that cell.
  bool covers(ImageSize size, const Eigen::Vector2d& pixel) const;
};

/// A calibrated camera in its place on the rig.
struct RigCamera {
  std::string name;
  Camera camera;
  Rigid3 camera_from_rig;
  std::optional<CornerEvidence> evidence = {};  ///< nothing for a camera that no corners were solved for
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

  /// Where each of the names stands; -1 for parameters that were not estimated.
  std::vector<int> places_of(const std::vector<std::string>& some) const;

  /// The part of the matrix for some names, in their order; zero for those that were not estimated.
  Eigen::MatrixXd block(const std::vector<std::string>& some) const;
};

/// What is saved: intrinsics, extrinsics, board shapes and how well they are known.
struct Calibration {
  std::vector<RigCamera> cameras;  ///< the first one defines the rig frame
  std::vector<CalibratedTarget> targets;
  Covariance covariance;  ///< for errors that are independent from corner to corner
  std::optional<LaserPattern> laser;
  /// Of the same names, from how the frames disagree: for corners of a frame that err together. Nothing when the frames
  /// are too few to tell.
  std::optional<Covariance> covariance_by_frame = {};
};

/// The camera of that name. Throws Error(kBadInput) that lists the names there are.
const RigCamera& camera_named(const Calibration& calibration, const std::string& name);

}  // namespace raybundle
