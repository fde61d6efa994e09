// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/view_block.hpp"

namespace raybundle {

/// What moves of a BundleState.
struct Unknowns {
  std::vector<Eigen::VectorXd> intrinsics;  ///< of each camera
  std::vector<Rigid3> camera_from_rig;      ///< of each camera
  std::vector<Rigid3> rig_from_target;      ///< of each pose
  std::vector<Eigen::Vector3d> shapes;      ///< of each target: bend_x, bend_y, twist [m]
  std::vector<Line3> beams;                 ///< aligned with BundleState::beams; those that it lacks mean nothing

  explicit Unknowns(const BundleState& state);
  void store(BundleState& state) const;
  ViewPoint at(const ViewData& view) const { return at(view.camera, view.pose, view.target); }
  ViewPoint at(int camera, int pose, int target) const;
};

}  // namespace raybundle
