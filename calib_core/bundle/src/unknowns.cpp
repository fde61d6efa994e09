// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "unknowns.hpp"

namespace raybundle {

Unknowns::Unknowns(const BundleState& state) : camera_from_rig(state.camera_from_rig) {
  for (const Camera& camera : state.cameras) intrinsics.push_back(camera.parameters);
  for (const BoardPose& pose : state.poses) rig_from_target.push_back(pose.rig_from_target);
  for (const BoardShape& shape : state.shapes) shapes.push_back(shape.sags());
  for (const std::optional<Line3>& beam : state.beams) beams.push_back(beam.value_or(Line3{}));
}

void Unknowns::store(BundleState& state) const {
  state.camera_from_rig = camera_from_rig;
  for (std::size_t c = 0; c < intrinsics.size(); ++c) state.cameras[c].parameters = intrinsics[c];
  for (std::size_t p = 0; p < rig_from_target.size(); ++p) state.poses[p].rig_from_target = rig_from_target[p];
  for (std::size_t t = 0; t < shapes.size(); ++t) state.shapes[t] = BoardShape::from_sags(shapes[t]);
  for (std::size_t b = 0; b < beams.size(); ++b) {
    if (state.beams[b]) state.beams[b] = beams[b];
  }
}

ViewPoint Unknowns::at(int camera, int pose, int target) const {
  return {intrinsics[camera].data(), camera_from_rig[camera], rig_from_target[pose], shapes[target]};
}

}  // namespace raybundle
