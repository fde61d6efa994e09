// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "ties.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/initialize/tie_check.hpp"

namespace raybundle {
namespace {

constexpr double kShareOfTheSameMoment = 0.1;  // of the frames, at least ...
constexpr std::size_t kFewestFrames = 3;       // ... and so many: a pose of cameras that one frame gives fits it
constexpr double kAlike = 5.0;                 // times what frames of the same moment err

// Whether the camera could see at least half of the view's corners with the board where its pose has it.
bool in_sight(const CalibrationProblem& problem, const BundleState& state, int view) {
  const std::vector<Eigen::Vector2d> residuals = view_residuals(problem, state, view);
  const auto projected = std::ranges::count_if(residuals, [](const Eigen::Vector2d& r) { return r.allFinite(); });
  return 2 * projected >= static_cast<std::ptrdiff_t>(residuals.size());
}

// Every frame tied: the views of a board in a frame share the pose of the first of them. A view whose camera could not
// even see the board there begins another one: no solve could start from it.
BundleState with_all_ties(const CalibrationProblem& problem, const BundleState& state) {
  BundleState tied = state;
  std::map<std::pair<int, int>, std::vector<int>> poses_of_board;  // by frame and target
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    std::vector<int>& poses = poses_of_board[{problem.views[v].frame, problem.views[v].target}];
    const bool shared = std::ranges::any_of(poses, [&](int pose) {
      tied.pose_of_view[v] = pose;
      return in_sight(problem, tied, v);
    });
    if (shared) continue;
    tied.pose_of_view[v] = state.pose_of_view[v];
    poses.push_back(state.pose_of_view[v]);
  }
  mark_projectable(problem, tied);
  return tied;
}

// Views that have a pose of their own although other cameras saw the board in the frame.
std::vector<SetAside> views_out_of_sight(const CalibrationProblem& problem, const BundleState& tied) {
  std::map<int, int> views_of_pose;
  std::map<std::pair<int, int>, std::set<int>> poses_of_board;  // by frame and target
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const int pose = tied.pose_of_view[v];
    if (pose < 0) continue;
    ++views_of_pose[pose];
    poses_of_board[{problem.views[v].frame, problem.views[v].target}].insert(pose);
  }
  std::vector<SetAside> untied;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const int pose = tied.pose_of_view[v];
    if (pose < 0 || views_of_pose[pose] > 1) continue;
    if (poses_of_board[{problem.views[v].frame, problem.views[v].target}].size() < 2) continue;
    untied.push_back({v, SetAside::Scope::kExtrinsics,
                      "another camera saw the board where " + problem.cameras[problem.views[v].camera].name +
                          " could not have seen it, or the other way round"});
  }
  return untied;
}

// Moves only the boards.
void solve_poses(const CalibrationProblem& problem, BundleState& state, int threads, double settled) {
  CalibrationProblem poses_only = problem;
  poses_only.rules = {{"*", ParameterRule::Kind::kFixed, {}, 0.0}};
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {  // held as they are now, not at the problem's start
    poses_only.cameras[c].parameters = state.cameras[c].parameters;
    poses_only.cameras[c].camera_from_rig = state.camera_from_rig[c];
  }
  BundleOptions options;
  options.threads = threads;
  options.settled = settled;
  solve_bundle(poses_only, state, options);
}

// Excess beyond which a frame does not tie. Frames of the same moment err alike, those of another one by far more.
double tie_limit(const std::vector<TieCheck>& checks, double tie_sigma, const TieRule& rule, TieReview& review) {
  std::vector<double> values;
  for (const TieCheck& check : checks) values.push_back(check.excess);
  std::ranges::sort(values);
  const std::size_t last = values.size() - 1;
  const auto best_of = [&](double share) {
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(last));  // as in quantile()
    return values[std::min(std::max(rank, kFewestFrames - 1), last)];
  };
  const double best = best_of(rule.share_kept);
  const double alike = rule.wary ? kAlike * best_of(kShareOfTheSameMoment) : values.back();
  review.doubtful = best > tie_sigma;
  review.strict = !rule.unsynchronised && !review.doubtful;
  return rule.unsynchronised ? std::min(3.0 * values[last / 2], alike) : std::max(tie_sigma, std::min(best, alike));
}

// For each view the first one that shares its board pose: the same for states that tie the same views.
std::vector<int> first_sharing(const std::vector<int>& pose_of_view) {
  std::map<int, int> first_of_pose;
  std::vector<int> first;
  for (int v = 0; v < static_cast<int>(pose_of_view.size()); ++v) {
    first.push_back(pose_of_view[v] < 0 ? -1 : first_of_pose.insert({pose_of_view[v], v}).first->second);
  }
  return first;
}

}  // namespace

TieReview review_ties(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                      const TieRule& rule, double settled) {
  BundleState tied = with_all_ties(problem, state);
  solve_poses(problem, tied, options.threads, settled);
  const std::vector<TieCheck> checks = check_ties(problem, tied.cameras, tied.camera_from_rig, tied.shapes, tied.poses,
                                                  tied.pose_of_view, options.threads);
  TieReview review{.untied = views_out_of_sight(problem, tied)};
  if (checks.empty()) return review;
  const double limit = tie_limit(checks, options.tie_sigma, rule, review);
  std::vector<double> tied_px;
  for (const TieCheck& check : checks) {
    if (check.excess <= limit) {
      tied_px.push_back(check.tied_rms_px);
      continue;
    }
    for (std::size_t i = 0; i < check.views.size(); ++i) {
      const int view = check.views[i];
      review.untied.push_back({view, SetAside::Scope::kExtrinsics, check.reason});
      const Rigid3& camera_from_rig = tied.camera_from_rig[problem.views[view].camera];
      const Rigid3 own = camera_from_rig.inverse() * check.camera_from_target[i];
      if (i == 0) {
        tied.poses[check.pose].rig_from_target = own;
      } else {
        tied.pose_of_view[view] = static_cast<int>(tied.poses.size());
        tied.poses.push_back({problem.views[view].frame, problem.views[view].target, own});
      }
    }
  }
  review.typical_px = median(tied_px);
  mark_projectable(problem, tied);
  review.changed = first_sharing(state.pose_of_view) != first_sharing(tied.pose_of_view);
  state = std::move(tied);
  return review;
}

}  // namespace raybundle
