// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <set>

#include "bundle_worlds.hpp"
#include "laser_world.hpp"
#include "raybundle/scene/board_surface.hpp"

namespace raybundle::testing {

/// A world with labelled dots, and its true answer.
struct LaserWorld {
  SyntheticWorld world;
  LaserTruth laser;
  BundleState truth;
};

/// Beams that fewer poses than `hits` met take no part.
inline LaserWorld laser_world(const SyntheticOptions& options, LaserOptions laser, int hits = 3) {
  laser.labelled = true;
  LaserWorld result{.world = synthetic_world(options), .laser = {}, .truth = {}};
  result.laser = add_laser(result.world, laser);
  result.truth = true_state(result.world);
  result.truth.beams = result.laser.lines;
  std::vector<std::set<int>> poses(result.truth.beams.size());
  for (std::size_t v = 0; v < result.world.problem.views.size(); ++v) {
    for (const Dot& dot : result.world.problem.views[v].dots) {
      if (dot.beam != kUnlabelled) poses[dot.beam].insert(result.truth.pose_of_view[v]);
    }
  }
  for (std::size_t b = 0; b < poses.size(); ++b) {
    if (static_cast<int>(poses[b].size()) < hits) result.truth.beams[b].reset();
  }
  mark_dots(result.world.problem, result.truth);
  return result;
}

/// One camera, or two beside each other, with boards near and far; few beams.
inline SyntheticOptions small_laser_rig(int cameras, int frames, unsigned seed = 1) {
  SyntheticOptions options = laser_rig_options(frames, seed);
  if (cameras > 1) {
    SyntheticCamera second = options.cameras[0];
    second.camera_from_rig = rig_camera("kannala_brandt", 0.05, -0.12).camera_from_rig;
    options.cameras.push_back(second);
  }
  return options;
}

/// The state as disturbed(), with beams some millimetres and milliradians away.
inline BundleState disturbed_beams(const BundleState& truth) {
  BundleState state = disturbed(truth);
  double phase = 0.4;
  for (std::optional<Line3>& beam : state.beams) {
    if (!beam) continue;
    Eigen::Vector4d motion;
    for (int i = 0; i < 4; ++i) motion[i] = 0.004 * std::sin(phase += 1.3);
    beam = perturbed(*beam, motion);
  }
  return state;
}

/// Largest offset [m] or slope [rad] between the beams of two states.
inline double largest_beam_difference(const BundleState& a, const BundleState& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.beams.size(); ++i) {
    if (!a.beams[i] || !b.beams[i]) continue;
    largest = std::max(largest, motion_between(*b.beams[i], *a.beams[i]).cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace raybundle::testing
