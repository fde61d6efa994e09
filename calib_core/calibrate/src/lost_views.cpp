// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lost_views.hpp"

#include <algorithm>
#include <utility>

#include "camera_corners.hpp"
#include "raybundle/initialize/camera_start.hpp"
#include "raybundle/initialize/other_optima.hpp"
#include "robust_solve.hpp"

namespace raybundle {
namespace {

constexpr int kFirstShapeParameter = 4;  // after fx, fy, cx and cy
constexpr double kPlainlyPosed = 0.7;    // of a view's corners fit where its pose is right
constexpr double kFitPx = 30.0;          // a right corner fits the simpler lens within this

// The state's lens with the first coefficient of its shape only.
Camera simpler_lens(const CalibrationProblem& single, const BundleState& state) {
  const CameraCorners corners = used_corners(single, state, 0);
  const Camera& lens = state.cameras[0];
  std::vector<int> zeros;
  for (int k = kFirstShapeParameter + 1; k < static_cast<int>(lens.parameters.size()); ++k) zeros.push_back(k);
  return fitted_anew(lens, corners.rays, corners.pixels, zeros);
}

// Gives views without a pose one under a lens; whether there are such views.
bool pose_lost_views(const CalibrationProblem& single, const Camera& lens, BundleState& state) {
  bool posed = false;
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    if (state.pose_of_view[v] >= 0) continue;
    const TargetView& view = single.views[v];
    std::string reason;
    const auto camera_from_target = initialize_view(single, view, lens, reason, kFitPx);
    if (!camera_from_target) continue;
    state.pose_of_view[v] = static_cast<int>(state.poses.size());
    state.poses.push_back({view.frame, view.target, *camera_from_target});
    posed = true;
  }
  return posed;
}

// Takes their poses from views of which many corners do not fit; whether there are such views.
bool take_doubtful_poses(BundleState& state) {
  bool taken = false;
  for (std::size_t v = 0; v < state.pose_of_view.size(); ++v) {
    const auto used = static_cast<double>(std::ranges::count(state.fates[v], ObservationFate::kUsed));
    if (state.pose_of_view[v] < 0 || used >= kPlainlyPosed * static_cast<double>(state.fates[v].size())) continue;
    state.pose_of_view[v] = -1;
    std::ranges::fill(state.fates[v], ObservationFate::kViewSetAside);
    taken = true;
  }
  return taken;
}

// Solves on from another place, and goes there if all corners fit better.
void move_if_better(const CalibrationProblem& single, BundleState other, const CalibrateOptions& options,
                    BundleState& state, std::vector<std::string>& reasons, BundleSummary& summary) {
  std::vector<std::string> other_reasons = reasons;
  mark_projectable(single, other);
  solve_robustly(single, other, options);
  const BundleSummary solved = solve_without_outliers(single, other, options, false, other_reasons);
  if (solved.termination == Termination::kFailed || !fits_better(single, other, state, options)) return;
  state = std::move(other);
  reasons = std::move(other_reasons);
  summary = solved;
}

}  // namespace

void win_back_views(const CalibrationProblem& single, BundleState& state, const CalibrateOptions& options,
                    std::vector<std::string>& reasons, BundleSummary& summary) {
  if (summary.termination == Termination::kFailed) return;
  BundleState other = state;
  if (take_doubtful_poses(other)) {
    std::vector<std::string> other_reasons = reasons;
    give_second_chance(single, other, options, other_reasons);
    move_if_better(single, std::move(other), options, state, reasons, summary);
  }
  if (std::ranges::none_of(state.pose_of_view, [](int pose) { return pose < 0; })) return;
  other = state;
  other.cameras[0] = simpler_lens(single, state);
  if (pose_lost_views(single, other.cameras[0], other)) {
    move_if_better(single, std::move(other), options, state, reasons, summary);
  }
}

}  // namespace raybundle
