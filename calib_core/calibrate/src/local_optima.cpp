// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "local_optima.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "camera_corners.hpp"
#include "corner_choice.hpp"
#include "grown_lens.hpp"
#include "lens_certainty.hpp"
#include "lower_optima.hpp"
#include "mirrored_boards.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/initialize/other_optima.hpp"
#include "weak_directions.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kMostRays = 400;  // of the lens's field, spread over the views
constexpr int kRounds = 6;              // from a lower optimum to the next
constexpr double kAlikeSigmas = 3.0;    // two optima of the same corners differ by no more in where they project
constexpr double kLeastAlike_px = 0.5;
constexpr double kMostAlike_px = 20.0;
constexpr std::size_t kOfEachSide = 8;     // cameras along the valley
constexpr double kLooseShare = 3e-4;       // of the image's longer side: a projection known no better is loose
constexpr std::size_t kMostLoose = 10000;  // corners: so many leave a lens loose by how the boards are held

// Aligned with the views.
std::vector<std::optional<Rigid3>> of_views(const CalibrationProblem& single,
                                            const std::vector<MirroredBoard>& mirrored) {
  std::vector<std::optional<Rigid3>> camera_from_target(single.views.size());
  for (const MirroredBoard& board : mirrored) camera_from_target[board.view] = board.camera_from_target;
  return camera_from_target;
}

// Other cameras that put rays where the state's does, as near as the corners can tell: twins of the model, and along
// the valleys that begin here and there. Where a solve has run against the end of its model's domain, the optimum may lie
// beyond it, and the way there leads around: also the lens that is fitted to the corners from the model's own starts.
std::vector<Camera> cameras_alike(const CalibrationProblem& single, const SolvedState& solved, double sigma_px) {
  const BundleState& state = solved.state;
  const std::vector<Eigen::Vector3d> rays = rays_seen(single, state);
  const double alike_px = std::clamp(kAlikeSigmas * sigma_px, kLeastAlike_px, kMostAlike_px);
  std::vector<Camera> alike = twin_cameras(state.cameras[0], rays, alike_px);
  if (solved.summary.termination == Termination::kBlocked) {
    const CameraCorners corners = used_corners(single, state, 0);
    alike.push_back(fitted_anew(state.cameras[0], corners.rays, corners.pixels));
  }
  std::vector<Camera> starts{state.cameras[0]};
  if (!alike.empty()) starts.push_back(alike.front());
  for (const Camera& start : starts) {
    std::ranges::copy(cameras_along_valley(start, rays, alike_px, kOfEachSide), std::back_inserter(alike));
  }
  return alike;
}

// Moves to the lowest optimum of a lens that puts corners nearly where the state's does, as near as they can tell, if
// it is lower.
bool move_to_lower_alike(const CalibrationProblem& single, const CalibrateOptions& options, CameraOptimum& optimum) {
  const std::vector<Camera> alike = cameras_alike(single, optimum.solved, optimum.projection_sigma_px);
  return move_to_lower(single, alike, options, optimum.solved);
}

// How well the projection is known by other lenses that fit nearly as well, which the slopes at the optimum do not see:
// the distance to such a lens over the sigmas by which it fits worse.
double sigma_by_others_px(const CalibrationProblem& single, const BundleState& state, double cost,
                          const std::vector<CostedState>& others) {
  const std::vector<Eigen::Vector3d> rays = rays_seen(single, state);
  const double variance = std::pow(robust_sigmas(single, state)[0], 2);
  double sigma_px = 0.0;
  for (const CostedState& other : others) {
    const double worse_by = std::sqrt(std::max(1.0, 2.0 * (other.cost - cost) / variance));
    if (worse_by > kAlikeSigmas) continue;
    const double distance_px = projection_distance_px(state.cameras[0], other.state.cameras[0], rays);
    if (std::isfinite(distance_px)) sigma_px = std::max(sigma_px, distance_px / worse_by);
  }
  return sigma_px;
}

// Views that leave a lens loose may have optima anywhere along what they do not tell. Moves to a lower one; where there
// is none, the lens is known no better than the lenses tell that the search came past.
bool move_to_lower_of_loose(const CalibrationProblem& single, const CalibrateOptions& options, CameraOptimum& optimum) {
  const BundleState& state = optimum.solved.state;
  if (!knows_loosely(optimum) || count_used(state) > kMostLoose) return false;
  std::vector<CostedState> starts = states_along_weakest(single, state, options.threads);
  std::vector<CostedState> come_past = states_of_other_focals(single, state, options.threads);
  starts.insert(starts.end(), come_past.begin(), come_past.end());
  if (move_to_lower(single, starts, options, optimum.solved)) return true;
  come_past.insert(come_past.end(), starts.begin(), starts.end());  // which are where the solves have come to
  const double by_others_px = sigma_by_others_px(single, state, optimum.solved.summary.final_cost, come_past);
  optimum.projection_sigma_px = std::max(optimum.projection_sigma_px, by_others_px);
  return false;
}

}  // namespace

bool knows_loosely(const CameraOptimum& optimum) {
  const ImageSize size = optimum.solved.state.cameras[0].size;
  return optimum.projection_sigma_px > kLooseShare * std::max(size.width, size.height);
}

std::vector<Eigen::Vector3d> rays_seen(const CalibrationProblem& single, const BundleState& state) {
  const std::vector<Eigen::Vector3d> rays = used_corners(single, state, 0).rays;
  const std::size_t stride = rays.size() / kMostRays + 1;
  std::vector<Eigen::Vector3d> some;
  for (std::size_t i = 0; i < rays.size(); i += stride) some.push_back(rays[i]);
  return some;
}

std::vector<std::optional<Rigid3>> mirrored_boards(const CalibrationProblem& single, const CameraOptimum& optimum,
                                                   int threads) {
  return optimum.mirrored ? *optimum.mirrored
                          : of_views(single, find_mirrored_boards(single, optimum.solved.state, threads));
}

CameraOptimum leave_local_optima(const CalibrationProblem& single, const CalibrateOptions& options,
                                 SolvedState solved) {
  CameraOptimum optimum{std::move(solved), std::nan("")};
  SolvedState& here = optimum.solved;
  const auto failed = [&] { return here.summary.termination == Termination::kFailed; };
  if (failed()) return optimum;
  std::optional<std::vector<MirroredBoard>> mirrored;  // of the state as it is
  const auto solve_on = [&](const BundleSummary& so_far) {
    mirrored.reset();
    here.summary = solve_without_outliers(single, here.state, options, false, here.reasons, so_far);
  };
  const auto turn_boards = [&] {
    mirrored = find_mirrored_boards(single, here.state, options.threads);
    if (turn_mirrored_boards(here.state, *mirrored)) {
      solve_on({});
      if (failed()) return;
      mirrored = find_mirrored_boards(single, here.state, options.threads);
    }
    // The camera that one board had bent may have kept another one from turning.
    for (int round = 0; round < kRounds && !failed(); ++round) {
      if (!try_mirrored_boards(single, *mirrored, options, here)) return;
      solve_on(here.summary);
      if (!failed()) mirrored = find_mirrored_boards(single, here.state, options.threads);
    }
  };
  const auto measure = [&] {
    optimum.projection_sigma_px = failed() ? std::nan("") : projection_sigma_px(single, here.state, options.threads);
  };
  const auto descend_by = [&](const auto& move) {
    for (int round = 0; round < kRounds && !failed() && move(single, options, optimum); ++round) {
      solve_on(here.summary);
      measure();
    }
  };
  const auto descend = [&] {
    measure();
    descend_by(move_to_lower_alike);
    descend_by(move_to_lower_of_loose);
  };
  turn_boards();
  descend();
  for (int round = 0; round < kRounds && !failed(); ++round) {
    if (!grow_lens(single, options, optimum) && !choose_corners_again(single, options, here)) break;
    mirrored.reset();
    if (!failed()) turn_boards();  // with other corners a board may be held otherwise
    descend();
  }
  if (mirrored) optimum.mirrored = of_views(single, *mirrored);
  return optimum;
}

}  // namespace raybundle
