// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "mirrored_boards.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/initialize/other_optima.hpp"

namespace raybundle {
namespace {

constexpr double kWonBack = 1000.0;      // squared sigmas that a turned board may cost at first: it has bent the lens
constexpr std::size_t kMostTried = 8;    // boards that are turned one by one
constexpr std::size_t kMostViews = 100;  // of which one could move the camera
constexpr double kMirroredGain = 1e-6;   // relative: by which a mirrored board's squares must be smaller

std::optional<MirroredPose> mirrored_pose_of(const CalibrationProblem& single, const BundleState& state,
                                             std::size_t v) {
  const int pose = state.pose_of_view[v];
  if (pose < 0) return std::nullopt;
  const TargetView& view = single.views[v];
  std::vector<Eigen::Vector3d> points;  // in the target
  std::vector<Eigen::Vector2d> pixels;
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    if (state.fates[v][i] != ObservationFate::kUsed) continue;
    points.push_back(single.targets[view.target].find(view.observations[i].point_id)->x_in_target);
    pixels.push_back(view.observations[i].pixel);
  }
  return find_mirrored_pose(state.cameras[0], points, pixels, state.poses[pose].rig_from_target);
}

}  // namespace

std::vector<MirroredBoard> find_mirrored_boards(const CalibrationProblem& single, const BundleState& state,
                                                int threads) {
  std::vector<std::optional<MirroredPose>> of_view(single.views.size());
  for_each_index(of_view.size(), threads, [&](std::size_t v) { of_view[v] = mirrored_pose_of(single, state, v); });
  std::vector<MirroredBoard> found;
  for (std::size_t v = 0; v < of_view.size(); ++v) {
    if (of_view[v]) found.push_back({v, of_view[v]->camera_from_target, of_view[v]->squares_ratio - 1.0});
  }
  return found;
}

bool turn_mirrored_boards(BundleState& state, const std::vector<MirroredBoard>& mirrored) {
  bool turned = false;
  for (const MirroredBoard& board : mirrored) {
    if (!(board.growth < -kMirroredGain)) continue;
    state.poses[state.pose_of_view[board.view]].rig_from_target = board.camera_from_target;
    turned = true;
  }
  return turned;
}

bool try_mirrored_boards(const CalibrationProblem& single, std::vector<MirroredBoard> mirrored,
                         const CalibrateOptions& options, SolvedState& solved) {
  auto& [state, reasons, summary] = solved;
  if (single.views.size() > kMostViews) return false;
  const double variance = std::pow(robust_sigmas(single, state)[0], 2);
  for (MirroredBoard& board : mirrored) {
    double squares = 0.0;
    const std::vector<Eigen::Vector2d> residuals = view_residuals(single, state, static_cast<int>(board.view));
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      if (state.fates[board.view][i] != ObservationFate::kUsed) continue;
      squares += residuals[i].squaredNorm() / std::pow(single.views[board.view].observations[i].sigma_px, 2);
    }
    board.growth *= squares / variance;
  }
  std::erase_if(mirrored, [](const MirroredBoard& board) { return !(board.growth < kWonBack); });
  std::ranges::stable_sort(mirrored, {}, &MirroredBoard::growth);
  if (mirrored.size() > kMostTried) mirrored.resize(kMostTried);
  const BundleOptions bundle = bundle_options(options);
  bool turned = false;
  for (const MirroredBoard& board : mirrored) {
    BundleState other = state;
    other.poses[other.pose_of_view[board.view]].rig_from_target = board.camera_from_target;
    const BundleSummary of_other = solve_bundle(single, other, bundle);
    if (of_other.termination == Termination::kFailed) continue;
    if (!(of_other.final_cost < (1.0 - kMirroredGain) * summary.final_cost)) continue;
    if (spoils_lens(single, state, other)) continue;
    state = std::move(other);
    summary = of_other;
    turned = true;
  }
  return turned;
}

}  // namespace raybundle
