// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "ties.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "raybundle/initialize/tie_check.hpp"

namespace raybundle {
namespace {

// Every frame tied: the views of a board in a frame share the pose of the first of them.
BundleState with_all_ties(const CalibrationProblem& problem, const BundleState& state) {
  BundleState tied = state;
  std::map<std::pair<int, int>, int> pose_of_board;  // by frame and target
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    const std::pair board{problem.views[v].frame, problem.views[v].target};
    tied.pose_of_view[v] = pose_of_board.insert({board, state.pose_of_view[v]}).first->second;
  }
  return tied;
}

// Moves only the boards.
void solve_poses(const CalibrationProblem& problem, BundleState& state, int threads) {
  CalibrationProblem poses_only = problem;
  poses_only.rules = {{"*", ParameterRule::Kind::kFixed, {}, 0.0}};
  BundleOptions options;
  options.threads = threads;
  options.robust_scale_sigma = 0.0;
  solve_bundle(poses_only, state, options);
}

double quantile(std::vector<double> values, double fraction) {
  const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[at];
}

// Excess beyond which a frame does not tie: of cameras that do not expose together only frames far worse than most.
double tie_limit(const std::vector<TieCheck>& checks, double tie_sigma, TieReview& review) {
  std::vector<double> values;
  for (const TieCheck& check : checks) values.push_back(check.excess);
  const double best = quantile(values, review.share_kept);
  review.doubtful = best > tie_sigma;
  return review.unsynchronised ? 3.0 * quantile(values, 0.5) : std::max(tie_sigma, best);
}

}  // namespace

bool review_ties(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                 TieReview& review) {
  BundleState tied = with_all_ties(problem, state);
  solve_poses(problem, tied, options.threads);
  const std::vector<TieCheck> checks =
      check_ties(problem, tied.cameras, tied.camera_from_rig, tied.poses, tied.pose_of_view);
  if (checks.empty()) return false;
  const double limit = tie_limit(checks, options.tie_sigma, review);
  review.untied.clear();
  for (const TieCheck& check : checks) {
    if (check.excess <= limit) continue;
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
  std::set<int> before(state.pose_of_view.begin(), state.pose_of_view.end());
  std::set<int> after(tied.pose_of_view.begin(), tied.pose_of_view.end());
  const bool changed = before.size() != after.size();
  state = std::move(tied);
  return changed;
}

}  // namespace raybundle
