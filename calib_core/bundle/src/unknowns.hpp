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

/// A BundleState as plain numbers, for Ceres. All of them stand in one array, because Ceres orders parameter blocks by
/// their addresses, and the order of summation must not depend on where the heap happens to put them.
class Unknowns {
 public:
  explicit Unknowns(const BundleState& state);
  Unknowns(const Unknowns&) = delete;  // Ceres holds addresses
  Unknowns& operator=(const Unknowns&) = delete;

  void store(BundleState& state) const;
  ViewPoint at(const ViewData& view) const;
  double* values(const ParameterBlock& block);

  double* intrinsics(int camera) { return &numbers_[intrinsics_[camera]]; }
  double* camera_from_rig(int camera) { return &numbers_[camera_from_rig_[camera]]; }  ///< a PoseArray
  double* rig_from_target(int pose) { return &numbers_[rig_from_target_[pose]]; }      ///< a PoseArray
  double* shape(int target) { return &numbers_[shapes_[target]]; }                     ///< bend_x, bend_y, twist

 private:
  std::vector<double> numbers_;
  std::vector<std::size_t> intrinsics_, camera_from_rig_, rig_from_target_, shapes_;  // where each one begins
};

}  // namespace raybundle
