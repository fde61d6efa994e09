// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "raybundle/bundle/parameters.hpp"
#include "raybundle/bundle/view_block.hpp"

namespace raybundle {

using PoseArray = std::array<double, 7>;  ///< quaternion x y z w, translation: Eigen's and our files' order

PoseArray array_from(const Rigid3& pose);
Rigid3 rigid_from(const double* pose);

/// A BundleState as plain arrays, for Ceres.
struct Unknowns {
  std::vector<Eigen::VectorXd> intrinsics;
  std::vector<PoseArray> camera_from_rig;
  std::vector<PoseArray> rig_from_target;
  std::vector<std::array<double, 3>> shapes;

  explicit Unknowns(const BundleState& state);
  void store(BundleState& state) const;

  ViewPoint at(const ViewData& view) const;
  double* values(const ParameterBlock& block);
};

}  // namespace raybundle
