// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "local_optima.hpp"

#include <algorithm>

#include "raybundle/initialize/other_optima.hpp"
#include "robust_solve.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kMostRays = 400;  // of the lens's field, spread over the views
constexpr double kLower = 1e-7;         // relative: by which another optimum's cost must be lower
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

}  // namespace

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
  BundleOptions bundle;
  bundle.max_iterations = options.max_iterations;
  bundle.threads = options.threads;
  bool better = false;
  for (const Camera& twin : twin_cameras(state.cameras[0], rays_seen(single, state))) {
    BundleState other = state;
    other.cameras[0] = twin;
    const BundleSummary of_other = solve_bundle(single, other, bundle);
    if (of_other.termination == Termination::kFailed) continue;
    if (!(of_other.final_cost < (1.0 - kLower) * summary.final_cost)) continue;
    state = std::move(other);
    summary = of_other;
    better = true;
  }
  return better ? solve_without_outliers(single, state, options, false, reasons, summary) : summary;
}

}  // namespace raybundle
