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
  for (const Camera& camera : state.cameras) intrinsics.push_back(camera.parameters);
  for (const Rigid3& pose : state.camera_from_rig) camera_from_rig.push_back(array_from(pose));
  for (const BoardPose& pose : state.poses) rig_from_target.push_back(array_from(pose.rig_from_target));
  for (const BoardShape& shape : state.shapes) shapes.push_back({shape.bend_x_m, shape.bend_y_m, shape.twist_m});
}

void Unknowns::store(BundleState& state) const {
  for (std::size_t c = 0; c < intrinsics.size(); ++c) {
    state.cameras[c].parameters = intrinsics[c];
    state.camera_from_rig[c] = rigid_from(camera_from_rig[c].data());
  }
  for (std::size_t p = 0; p < rig_from_target.size(); ++p) {
    state.poses[p].rig_from_target = rigid_from(rig_from_target[p].data());
  }
  for (std::size_t t = 0; t < shapes.size(); ++t) state.shapes[t] = {shapes[t][0], shapes[t][1], shapes[t][2]};
}

ViewPoint Unknowns::at(const ViewData& view) const {
  const std::array<double, 3>& shape = shapes[view.target];
  return {intrinsics[view.camera].data(), rigid_from(camera_from_rig[view.camera].data()),
          rigid_from(rig_from_target[view.pose].data()), Eigen::Vector3d(shape[0], shape[1], shape[2])};
}

double* Unknowns::values(const ParameterBlock& block) {
  switch (block.kind) {
    case ParameterBlock::Kind::kIntrinsics:
      return intrinsics[block.owner].data();
    case ParameterBlock::Kind::kCameraFromRig:
      return camera_from_rig[block.owner].data();
    case ParameterBlock::Kind::kShape:
      break;
  }
  return shapes[block.owner].data();
}

}  // namespace raybundle
