// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lost_views.hpp"

#include <algorithm>
#include <utility>

#include "camera_corners.hpp"
#include "grown_lens.hpp"
#include "raybundle/initialize/camera_start.hpp"
#include "raybundle/initialize/other_optima.hpp"
#include "robust_solve.hpp"

namespace raybundle {
namespace {

constexpr double kPlainlyPosed = 0.7;  // of a view's corners fit where its pose is right
constexpr double kFitOfWidth = 0.025;  // of the image: a right corner fits the simpler lens within this

// Gives views without a pose one under a lens that corners fit that well; whether there are such views.
bool pose_lost_views(const CalibrationProblem& single, const Camera& lens, double fit_px, BundleState& state) {
  bool posed = false;
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    if (state.pose_of_view[v] >= 0) continue;
    const TargetView& view = single.views[v];
    std::string reason;
    const auto camera_from_target = initialize_view(single, view, lens, reason, fit_px);
    if (!camera_from_target) continue;
    state.pose_of_view[v] = static_cast<int>(state.poses.size());
    state.poses.push_back({view.frame, view.target, *camera_from_target});
    posed = true;
  }
  return posed;
}

// Views with a pose that many of their corners do not fit.
std::vector<std::size_t> doubtful_views(const BundleState& state) {
  std::vector<std::size_t> doubtful;
  for (std::size_t v = 0; v < state.pose_of_view.size(); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    const auto used = static_cast<double>(std::ranges::count(state.fates[v], ObservationFate::kUsed));
    if (used < kPlainlyPosed * static_cast<double>(state.fates[v].size())) doubtful.push_back(v);
  }
  return doubtful;
}

// Solves on from another place, where right corners may be so far off, and goes there if that is better.
bool move_if_better(const CalibrationProblem& single, SolvedState other, double off_px, const CalibrateOptions& options,
                    SolvedState& solved) {
  mark_projectable(single, other.state);
  solve_robustly(single, other.state, options, off_px);
  other.summary = solve_without_outliers(single, other.state, options, false, other.reasons);
  const bool better = is_better(single, other, solved, options);
  if (better) solved = std::move(other);
  return better;
}

bool pose_doubtful_views_anew(const CalibrationProblem& single, const CalibrateOptions& options, SolvedState& solved) {
  const std::vector<std::size_t> doubtful = doubtful_views(solved.state);
  if (doubtful.empty()) return false;
  SolvedState other = solved;
  for (const std::size_t v : doubtful) {
    other.state.pose_of_view[v] = -1;
    std::ranges::fill(other.state.fates[v], ObservationFate::kViewSetAside);
  }
  if (!give_second_chance(single, other.state, options, other.reasons)) return false;
  return move_if_better(single, std::move(other), 0.0, options, solved);
}

// Poses lost views under a lens that their right corners may be far from.
bool win_back_under(const Camera& lens, const CalibrationProblem& single, const CalibrateOptions& options,
                    SolvedState& solved) {
  SolvedState other = solved;
  other.state.cameras[0] = lens;
  const double fit_px = kFitOfWidth * std::max(lens.size.width, lens.size.height);
  if (!pose_lost_views(single, lens, fit_px, other.state)) return false;
  return move_if_better(single, std::move(other), fit_px, options, solved);
}

bool win_back_lost_views(const CalibrationProblem& single, const CalibrateOptions& options, SolvedState& solved) {
  const auto lost = [](int pose) { return pose < 0; };
  if (std::ranges::none_of(solved.state.pose_of_view, lost)) return false;
  const Camera lens = solved.state.cameras[0];
  if (win_back_under(lens, single, options, solved)) return true;
  const std::vector<int> higher = higher_coefficients(lens.model);
  if (higher.empty()) return false;
  const CameraCorners corners = used_corners(single, solved.state, 0);
  return win_back_under(fitted_anew(lens, corners.rays, corners.pixels, higher), single, options, solved);
}

}  // namespace

bool win_back_views(const CalibrationProblem& single, const CalibrateOptions& options, SolvedState& solved) {
  if (solved.summary.termination == Termination::kFailed) return false;
  const bool posed_anew = pose_doubtful_views_anew(single, options, solved);
  return win_back_lost_views(single, options, solved) || posed_anew;
}

}  // namespace raybundle
