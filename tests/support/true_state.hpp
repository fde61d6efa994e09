// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"
#include "synthetic_world.hpp"

namespace raybundle::testing {

/// The true answer as a state in which everything is used.
inline BundleState true_state(const SyntheticWorld& world) {
  BundleState state{.cameras = world.cameras,
                    .camera_from_rig = world.camera_from_rig,
                    .poses = world.poses,
                    .shapes = world.shapes,
                    .pose_of_view = world.pose_of_view,
                    .fates = {}};
  mark_projectable(world.problem, state);
  return state;
}

}  // namespace raybundle::testing
