// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "subproblem.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "raybundle/bundle/parameters.hpp"

namespace raybundle {
namespace {

// Extrinsics as seen from the first of the cameras; where its place in the rig is unknown, theirs are too.
void refer_to_first(std::vector<ProblemCamera>& cameras, std::optional<Rigid3> first_from_rig) {
  for (ProblemCamera& camera : cameras) {
    if (!first_from_rig) camera.camera_from_rig.reset();
    if (camera.camera_from_rig) camera.camera_from_rig = *camera.camera_from_rig * first_from_rig->inverse();
  }
}

/// @param take  gives the view of an index in the whole problem
template <typename Take>
Subproblem select(const CalibrationProblem& whole, const std::vector<int>& cameras, const Take& take) {
  Subproblem sub;
  sub.problem.targets = whole.targets;
  sub.problem.frames = whole.frames;
  for (int c : cameras) sub.problem.cameras.push_back(whole.cameras[c]);
  std::optional<Rigid3> first_from_rig = sub.problem.cameras.front().camera_from_rig;
  if (cameras.front() == 0 && !first_from_rig) first_from_rig = Rigid3{};
  refer_to_first(sub.problem.cameras, first_from_rig);
  for (std::size_t v = 0; v < whole.views.size(); ++v) {
    const auto found = std::ranges::find(cameras, whole.views[v].camera);
    if (found == cameras.end()) continue;
    sub.problem.views.push_back(take(v));
    sub.problem.views.back().camera = static_cast<int>(found - cameras.begin());
    sub.views.push_back(static_cast<int>(v));
  }
  sub.problem.survey = whole.survey;
  sub.problem.laser = whole.laser;
  if (whole.laser && whole.laser->anchor) {
    const auto anchored = std::ranges::find(sub.views, whole.laser->anchor->view);
    sub.problem.laser->anchor.reset();
    if (anchored != sub.views.end()) {
      sub.problem.laser->anchor = whole.laser->anchor;
      sub.problem.laser->anchor->view = static_cast<int>(anchored - sub.views.begin());
    }
  }
  const bool same_frame = cameras.front() == 0;
  std::ranges::copy_if(whole.rules, std::back_inserter(sub.problem.rules), [&](const ParameterRule& rule) {
    return matches_any(rule, sub.problem) && (same_frame || !bound_to_frame(rule, first_from_rig.has_value()));
  });
  return sub;
}

}  // namespace

bool bound_to_frame(const ParameterRule& rule, bool new_frame_known) {
  const bool keeps = rule.kind != ParameterRule::Kind::kFree && (rule.value || !new_frame_known);
  return keeps && rule.pattern.find("camera_from_rig") != std::string::npos;
}

Subproblem select_cameras(const CalibrationProblem& whole, const std::vector<int>& cameras) {
  return select(whole, cameras, [&](std::size_t v) { return whole.views[v]; });
}

Subproblem take_cameras(CalibrationProblem& whole, const std::vector<int>& cameras) {
  return select(whole, cameras, [&](std::size_t v) { return std::move(whole.views[v]); });
}

CalibrationProblem with_fixed_intrinsics(const CalibrationProblem& problem, const BundleState& state) {
  CalibrationProblem fixed = problem;
  fixed.rules.push_back({"*.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0});
  // A fixed parameter goes to the problem's start, which is not what is to be held here.
  for (std::size_t c = 0; c < state.cameras.size(); ++c) fixed.cameras[c].parameters = state.cameras[c].parameters;
  return fixed;
}

void relabel(CalibrationProblem& problem, const std::vector<int>& symmetry_of_view) {
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    TargetView& view = problem.views[v];
    relabel(problem.targets[view.target], symmetry_of_view[v], view.observations);
  }
}

void scale_corners(CalibrationProblem& problem, double scale) {
  double most = 0.0;
  for (TargetView& view : problem.views) {
    for (Observation& observation : view.observations) {
      const double scaled_px = std::max(scale * observation.sigma_px, kSmallestSigma_px);
      most = std::max(most, scaled_px / observation.sigma_px);
      observation.sigma_px = scaled_px;
    }
  }
  for (ParameterRule& rule : problem.rules) {
    if (rule.kind == ParameterRule::Kind::kPrior) rule.sigma *= most;
  }
}

BundleState with_fewer_views(const BundleState& state, std::size_t corners) {
  std::size_t all = 0;
  for (std::size_t v = 0; v < state.fates.size(); ++v) {
    if (state.pose_of_view[v] >= 0) all += state.fates[v].size();
  }
  const std::size_t stride = std::max<std::size_t>(1, (all + corners - 1) / corners);
  std::map<int, std::size_t> rank;  // of a pose, by its first view
  BundleState fewer = state;
  for (int& pose : fewer.pose_of_view) {
    if (pose >= 0 && rank.try_emplace(pose, rank.size()).first->second % stride != 0) pose = -1;
  }
  return fewer;
}

BundleState state_from_start(const CalibrationProblem& single, const CameraStart& start) {
  BundleState state;
  state.cameras = {start.camera};
  state.camera_from_rig = {Rigid3{}};
  state.shapes.resize(single.targets.size());
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    state.pose_of_view.push_back(start.camera_from_target[v] ? static_cast<int>(state.poses.size()) : -1);
    if (!start.camera_from_target[v]) continue;
    state.poses.push_back({single.views[v].frame, single.views[v].target, *start.camera_from_target[v]});
  }
  mark_projectable(single, state);
  return state;
}

}  // namespace raybundle
