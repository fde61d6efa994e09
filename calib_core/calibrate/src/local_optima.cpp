// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "local_optima.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "raybundle/initialize/other_optima.hpp"
#include "robust_solve.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kMostRays = 400;  // of the lens's field, spread over the views
constexpr double kLower = 1e-7;         // relative: by which another optimum's cost must be lower
constexpr double kPromising = 1.01;     // times the cost, after the first look
constexpr int kFirstLook = 30;          // iterations
constexpr std::size_t kFollowed = 2;    // solves that are followed to their end
constexpr std::size_t kBudget = 6000;   // corners that decide whether there is a lower optimum
constexpr std::size_t kOfEachSide = 3;  // cameras along the valley
constexpr double kMirroredGain = 1e-6;  // relative: by which a mirrored board's squares must be smaller

/// The corners in use of a view.
struct UsedCorners {
  std::vector<Eigen::Vector3d> points;  // in the target [m]
  std::vector<Eigen::Vector2d> pixels;
};

UsedCorners used_corners(const CalibrationProblem& problem, const BundleState& state, std::size_t v) {
  UsedCorners used;
  const TargetView& view = problem.views[v];
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    if (state.fates[v][i] != ObservationFate::kUsed) continue;
    used.points.push_back(problem.targets[view.target].find(view.observations[i].point_id)->x_in_target);
    used.pixels.push_back(view.observations[i].pixel);
  }
  return used;
}

bool turn_mirrored_boards(const CalibrationProblem& single, BundleState& state) {
  bool turned = false;
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    const int pose = state.pose_of_view[v];
    if (pose < 0) continue;
    const UsedCorners used = used_corners(single, state, v);
    Rigid3& board = state.poses[pose].rig_from_target;
    const auto mirrored = find_mirrored_pose(state.cameras[0], used.points, used.pixels, board);
    if (!mirrored || !(mirrored->squares_ratio < 1.0 - kMirroredGain)) continue;
    board = mirrored->camera_from_target;
    turned = true;
  }
  return turned;
}

// Projections that differ by less than this the corners cannot tell apart: some sigmas of what so many corners know.
double indistinguishable_px(const CalibrationProblem& single, const BundleState& state) {
  double corners = 0.0, sum_of_sigmas = 0.0;
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    for (const Observation& observation : single.views[v].observations) sum_of_sigmas += observation.sigma_px;
    corners += static_cast<double>(single.views[v].observations.size());
  }
  if (corners == 0.0) return 0.0;
  const double noise_px = robust_sigmas(single, state)[0] * sum_of_sigmas / corners;
  const double known = std::sqrt(static_cast<double>(state.cameras[0].parameters.size()) / (2.0 * corners));
  return noise_px * std::min(10.0 * known, 3.0);
}

// The state with every so many views only, so that the corners stay within a budget.
BundleState with_fewer_views(const BundleState& state) {
  std::size_t corners = 0;
  for (std::size_t v = 0; v < state.fates.size(); ++v) {
    if (state.pose_of_view[v] >= 0) corners += state.fates[v].size();
  }
  const std::size_t stride = (corners + kBudget - 1) / kBudget;
  BundleState fewer = state;
  std::size_t used = 0;
  for (int& pose : fewer.pose_of_view) {
    if (pose >= 0 && used++ % stride != 0) pose = -1;
  }
  return fewer;
}

/// Another optimum, or a place on the way to one.
struct OtherSolve {
  BundleState state;
  BundleSummary summary;
};

// Solves on from other cameras with the boards where they are: all of them for some steps, then the lowest that have
// not come to rest. Those that are lower than where the state was, the lowest first.
std::vector<OtherSolve> lower_optima(const CalibrationProblem& single, const BundleState& state, double cost,
                                     const std::vector<Camera>& others, BundleOptions bundle) {
  const int most_iterations = bundle.max_iterations;
  bundle.max_iterations = std::min(most_iterations, kFirstLook);
  const auto by_cost = [](const OtherSolve& solve) { return solve.summary.final_cost; };
  std::vector<OtherSolve> solves;
  for (const Camera& camera : others) {
    OtherSolve other{state, {}};
    other.state.cameras[0] = camera;
    other.summary = solve_bundle(single, other.state, bundle);
    if (other.summary.termination == Termination::kFailed) continue;
    const bool at_rest = other.summary.termination == Termination::kConverged;
    if (other.summary.final_cost < (at_rest ? 1.0 - kLower : kPromising) * cost) solves.push_back(std::move(other));
  }
  std::ranges::stable_sort(solves, {}, by_cost);
  if (solves.size() > kFollowed) solves.resize(kFollowed);
  bundle.max_iterations = most_iterations;
  for (OtherSolve& other : solves) {
    if (other.summary.termination == Termination::kIterationLimit) {
      other.summary = solve_bundle(single, other.state, bundle);
    }
  }
  std::erase_if(solves, [&](const OtherSolve& other) {
    return other.summary.termination == Termination::kFailed || !(other.summary.final_cost < (1.0 - kLower) * cost);
  });
  std::ranges::stable_sort(solves, {}, by_cost);
  return solves;
}

// Moves to the lowest optimum that other cameras lead to, if it is lower than where the state is. Of many views some
// tell whether there is one.
bool move_to_lower(const CalibrationProblem& single, BundleState& state, const std::vector<Camera>& others,
                   const CalibrateOptions& options, BundleSummary& summary) {
  if (others.empty()) return false;
  BundleOptions bundle;
  bundle.threads = options.threads;
  bundle.max_iterations = options.max_iterations;
  BundleState fewer = with_fewer_views(state);
  const bool all = fewer.pose_of_view == state.pose_of_view;
  const double cost = all ? summary.final_cost : solve_bundle(single, fewer, bundle).final_cost;
  std::vector<OtherSolve> lower = lower_optima(single, fewer, cost, others, bundle);
  if (!all && !lower.empty()) {
    lower = lower_optima(single, state, summary.final_cost, {lower.front().state.cameras[0]}, bundle);
  }
  if (lower.empty()) return false;
  state = std::move(lower.front().state);
  summary = lower.front().summary;
  return true;
}

}  // namespace

std::vector<Eigen::Vector3d> rays_seen(const CalibrationProblem& single, const BundleState& state) {
  std::vector<Eigen::Vector3d> rays;
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    for (const Eigen::Vector3d& point : used_corners(single, state, v).points) {
      rays.push_back((state.poses[state.pose_of_view[v]].rig_from_target * point).normalized());
    }
  }
  const std::size_t stride = rays.size() / kMostRays + 1;
  std::vector<Eigen::Vector3d> some;
  for (std::size_t i = 0; i < rays.size(); i += stride) some.push_back(rays[i]);
  return some;
}

std::vector<std::optional<Rigid3>> mirrored_boards(const CalibrationProblem& single, const BundleState& state) {
  std::vector<std::optional<Rigid3>> camera_from_target(single.views.size());
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    const int pose = state.pose_of_view[v];
    if (pose < 0) continue;
    const UsedCorners used = used_corners(single, state, v);
    const Rigid3& board = state.poses[pose].rig_from_target;
    const auto mirrored = find_mirrored_pose(state.cameras[0], used.points, used.pixels, board);
    if (mirrored) camera_from_target[v] = mirrored->camera_from_target;
  }
  return camera_from_target;
}

BundleSummary leave_local_optima(const CalibrationProblem& single, BundleState& state, const CalibrateOptions& options,
                                 std::vector<std::string>& reasons, const BundleSummary& solved) {
  if (solved.termination == Termination::kFailed) return solved;
  BundleSummary summary = solved;
  if (turn_mirrored_boards(single, state)) {
    summary = solve_without_outliers(single, state, options, false, reasons);
    if (summary.termination == Termination::kFailed) return summary;
  }
  const std::vector<Eigen::Vector3d> rays = rays_seen(single, state);
  std::vector<Camera> others = twin_cameras(state.cameras[0], rays);
  const double alike_px = indistinguishable_px(single, state);
  std::ranges::copy(cameras_along_valley(state.cameras[0], rays, alike_px, kOfEachSide), std::back_inserter(others));
  if (!move_to_lower(single, state, others, options, summary)) return summary;
  return solve_without_outliers(single, state, options, false, reasons, summary);
}

}  // namespace raybundle
