// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "plain_solve.hpp"

#include <algorithm>

#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/initialize/camera_start.hpp"
#include "raybundle/initialize/rig_start.hpp"

namespace raybundle::bench {
namespace {

// The part of a problem that one camera saw, with the views' places in the whole.
struct OneCamera {
  CalibrationProblem problem;
  std::vector<std::size_t> views;
};

OneCamera one_camera(const CalibrationProblem& problem, std::size_t camera) {
  OneCamera one;
  one.problem.targets = problem.targets;
  one.problem.frames = problem.frames;
  one.problem.cameras = {problem.cameras[camera]};
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera != static_cast<int>(camera)) continue;
    one.views.push_back(v);
    one.problem.views.push_back(problem.views[v]);
    one.problem.views.back().camera = 0;
  }
  return one;
}

void solve_with_priors(CalibrationProblem& problem, BundleState& state, int threads) {
  if (std::ranges::any_of(problem.cameras, can_have_pole, &ProblemCamera::model)) weigh_lens_priors(problem, state);
  solve_bundle(problem, state, {.threads = threads});
}

BundleState solve_one(CalibrationProblem& problem, int threads) {
  const CameraStart start = initialize_camera(problem, 0, threads);
  BundleState state;
  state.cameras = {start.camera};
  state.camera_from_rig = {Rigid3{}};
  state.shapes.resize(problem.targets.size());
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    state.pose_of_view.push_back(start.camera_from_target[v] ? static_cast<int>(state.poses.size()) : -1);
    if (!start.camera_from_target[v]) continue;
    state.poses.push_back({problem.views[v].frame, problem.views[v].target, *start.camera_from_target[v]});
  }
  mark_projectable(problem, state);
  solve_with_priors(problem, state, threads);
  return state;
}

}  // namespace

BundleState plain_solve(CalibrationProblem& problem, int threads) {
  if (problem.cameras.size() == 1) return solve_one(problem, threads);
  BundleState together;
  std::vector<std::optional<Rigid3>> camera_from_target(problem.views.size());
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    OneCamera one = one_camera(problem, c);
    const BundleState alone = solve_one(one.problem, threads);
    together.cameras.push_back(alone.cameras[0]);
    for (std::size_t v = 0; v < one.views.size(); ++v) {
      const int pose = alone.pose_of_view[v];
      if (pose >= 0) camera_from_target[one.views[v]] = alone.poses[static_cast<std::size_t>(pose)].rig_from_target;
    }
  }
  const RigStart rig = initialize_rig(problem, camera_from_target, {});
  together.camera_from_rig = rig.camera_from_rig;
  together.poses = rig.poses;
  together.pose_of_view = rig.pose_of_view;
  together.shapes.resize(problem.targets.size());
  mark_projectable(problem, together);
  solve_with_priors(problem, together, threads);
  return together;
}

}  // namespace raybundle::bench
