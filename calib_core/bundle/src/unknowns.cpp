// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "unknowns.hpp"

namespace raybundle {

PoseArray array_from(const Rigid3& pose) {
  PoseArray array{};
  Eigen::Map<Eigen::Vector4d>(array.data()) = pose.rotation.coeffs();
  Eigen::Map<Eigen::Vector3d>(array.data() + 4) = pose.translation;
  return array;
}

Rigid3 rigid_from(const double* pose) {
  return {Eigen::Quaterniond(Eigen::Map<const Eigen::Quaterniond>(pose)), Eigen::Vector3d(pose[4], pose[5], pose[6])};
}

Unknowns::Unknowns(const BundleState& state) {
  const auto append = [&](const auto& values) {
    const std::size_t begin = numbers_.size();
    numbers_.insert(numbers_.end(), values.begin(), values.end());
    return begin;
  };
  for (const Camera& camera : state.cameras) intrinsics_.push_back(append(camera.parameters));
  for (const Rigid3& pose : state.camera_from_rig) camera_from_rig_.push_back(append(array_from(pose)));
  for (const BoardPose& pose : state.poses) rig_from_target_.push_back(append(array_from(pose.rig_from_target)));
  for (const BoardShape& shape : state.shapes) {
    shapes_.push_back(append(std::array{shape.bend_x_m, shape.bend_y_m, shape.twist_m}));
  }
}

void Unknowns::store(BundleState& state) const {
  for (std::size_t c = 0; c < intrinsics_.size(); ++c) {
    Eigen::VectorXd& parameters = state.cameras[c].parameters;
    parameters = Eigen::Map<const Eigen::VectorXd>(&numbers_[intrinsics_[c]], parameters.size());
    state.camera_from_rig[c] = rigid_from(&numbers_[camera_from_rig_[c]]);
  }
  for (std::size_t p = 0; p < rig_from_target_.size(); ++p) {
    state.poses[p].rig_from_target = rigid_from(&numbers_[rig_from_target_[p]]);
  }
  for (std::size_t t = 0; t < shapes_.size(); ++t) {
    const double* shape = &numbers_[shapes_[t]];
    state.shapes[t] = {shape[0], shape[1], shape[2]};
  }
}

ViewPoint Unknowns::at(const ViewData& view) const {
  return {&numbers_[intrinsics_[view.camera]], rigid_from(&numbers_[camera_from_rig_[view.camera]]),
          rigid_from(&numbers_[rig_from_target_[view.pose]]),
          Eigen::Map<const Eigen::Vector3d>(&numbers_[shapes_[view.target]])};
}

double* Unknowns::values(const ParameterBlock& block) {
  switch (block.kind) {
    case ParameterBlock::Kind::kIntrinsics:
      return intrinsics(block.owner);
    case ParameterBlock::Kind::kCameraFromRig:
      return camera_from_rig(block.owner);
    case ParameterBlock::Kind::kShape:
      break;
  }
  return shape(block.owner);
}

}  // namespace raybundle
