// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "mirrored_boards.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
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
constexpr double kSame_rad = 1e-3;       // the way led back to the given pose

/// One view alone, under a camera that stays.
struct ViewAlone {
  CalibrationProblem problem;
  BundleState state;

  ViewAlone(const CalibrationProblem& single, const BundleState& of_all, std::size_t v) {
    const TargetView& view = single.views[v];
    problem.cameras = single.cameras;
    problem.cameras[0].parameters = of_all.cameras[0].parameters;
    problem.targets = {single.targets[view.target]};
    problem.frames = {single.frames[view.frame]};
    problem.views = {{.camera = 0, .frame = 0, .target = 0, .observations = view.observations}};
    problem.rules = {{"*.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0}};
    state.cameras = of_all.cameras;
    state.camera_from_rig = of_all.camera_from_rig;
    state.poses = {{0, 0, of_all.poses[of_all.pose_of_view[v]].rig_from_target}};
    state.shapes = {of_all.shapes[view.target]};
    state.pose_of_view = {0};
    state.fates = {of_all.fates[v]};
  }
};

// Whether the bundle takes a view as find_mirrored_pose() does: its board for flat, and all corners for equally sure.
bool plain(const TargetView& view, const BoardShape& shape) {
  return shape.sags().isZero(0.0) && std::ranges::adjacent_find(view.observations, std::ranges::not_equal_to{},
                                                                &Observation::sigma_px) == view.observations.end();
}

// A mirrored board as the bundle has it; nothing where the way leads back.
std::optional<MirroredBoard> settled(const ViewAlone& alone, const MirroredBoard& found) {
  BundleState here = alone.state, there = alone.state;
  Rigid3& pose = there.poses[0].rig_from_target;
  pose = found.camera_from_target;
  const BundleSummary of_here = solve_bundle(alone.problem, here, {.max_iterations = 0});
  const BundleSummary of_there = solve_bundle(alone.problem, there);
  if (of_there.termination == Termination::kFailed) return std::nullopt;
  if (angle_between(pose, here.poses[0].rig_from_target) < kSame_rad) return std::nullopt;
  return MirroredBoard{found.view, pose, of_there.final_cost / of_here.final_cost - 1.0};
}

std::optional<MirroredBoard> mirrored_board_of(const CalibrationProblem& single, const BundleState& state,
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
  const std::optional<MirroredPose> other =
      find_mirrored_pose(state.cameras[0], points, pixels, state.poses[pose].rig_from_target);
  if (!other) return std::nullopt;
  const MirroredBoard found{v, other->camera_from_target, other->squares_ratio - 1.0};
  return plain(view, state.shapes[view.target]) ? found : settled({single, state, v}, found);
}

}  // namespace

std::vector<MirroredBoard> find_mirrored_boards(const CalibrationProblem& single, const BundleState& state,
                                                int threads) {
  std::vector<std::optional<MirroredBoard>> of_view(single.views.size());
  for_each_index(of_view.size(), threads, [&](std::size_t v) { of_view[v] = mirrored_board_of(single, state, v); });
  std::vector<MirroredBoard> found;
  for (const std::optional<MirroredBoard>& board : of_view) {
    if (board) found.push_back(*board);
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
