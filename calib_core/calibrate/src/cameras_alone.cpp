// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "cameras_alone.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "lens_certainty.hpp"
#include "local_optima.hpp"
#include "lost_views.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/initialize/camera_start.hpp"
#include "robust_solve.hpp"
#include "stopwatch.hpp"
#include "subproblem.hpp"

namespace raybundle {
namespace {

constexpr int kMostWeighings = 4;  // of the prior, until the noise is that of the corners

CameraStart start_of(const CalibrationProblem& single, std::vector<StageTime>& stages) {
  const Stopwatch stopwatch(stages, "start");
  return initialize_camera(single, 0);
}

// Replaces a lens that ends among its corners. Tells the coefficients that had to be given up, and adds them to the
// problem's rules.
std::vector<ParameterRule> keep_lens_beyond_corners(CalibrationProblem& single, const CalibrateOptions& options,
                                                    CameraOptimum& optimum) {
  SolvedState& solved = optimum.solved;
  const auto solve = [&](const CalibrationProblem& simpler, BundleState& of_simpler) {
    solve_robustly(simpler, of_simpler, options);
    return solve_without_outliers(simpler, of_simpler, options, false, solved.reasons);
  };
  if (!ends_among_corners(single, solved.state, 0)) return {};
  CalibrationProblem simpler = single;
  if (!give_up_coefficients(simpler, solved.state, 0, solved.summary, solve)) return {};
  std::vector<ParameterRule> given_up(simpler.rules.begin() + static_cast<std::ptrdiff_t>(single.rules.size()),
                                      simpler.rules.end());
  // The lens that was replaced may have cost views.
  if (give_second_chance(simpler, solved.state, options, solved.reasons)) solved.summary = solve(simpler, solved.state);
  // With all coefficients there may be such a lens farther away, and a better one.
  CameraOptimum fuller = leave_local_optima(single, options, solved);
  if (given_up.empty() || is_better(single, fuller.solved, solved, options)) {
    optimum = std::move(fuller);
    return {};
  }
  single = std::move(simpler);
  optimum = leave_local_optima(single, options, std::move(solved));
  return given_up;
}

// Solves without outliers until the lens priors are those of the noise and the field that are left.
void settle_lens_priors(CalibrationProblem& single, const CalibrateOptions& options, SolvedState& solved) {
  auto& [state, reasons, summary] = solved;
  for (int round = 0; round < kMostWeighings && weigh_lens_priors(single, state); ++round) {
    summary = solve_without_outliers(single, state, options, false, reasons);
  }
}

// Leaves the lens priors of what it returns in the problem.
SolvedState solve_from(const CameraStart& start, CalibrationProblem& single, const CalibrateOptions& options) {
  SolvedState solved{state_from_start(single, start), start.reasons, {}};
  auto& [state, reasons, summary] = solved;
  weigh_lens_priors(single, state);
  solve_robustly(single, state, options);
  if (give_second_chance(single, state, options, reasons)) solve_robustly(single, state, options);
  summary = solve_without_outliers(single, state, options, false, reasons);
  settle_lens_priors(single, options, solved);
  return solved;
}

// Of lenses that a few views leave open, all corners decide.
SolvedState solve_from_best(const CameraStart& start, CalibrationProblem& single, const CalibrateOptions& options) {
  SolvedState best = solve_from(start, single, options);
  std::vector<ParameterRule> priors_of_best = single.lens_priors;
  for (const CameraStart& other : start.others) {
    SolvedState solved = solve_from(other, single, options);
    if (!is_better(single, solved, best, options)) continue;
    best = std::move(solved);
    priors_of_best = single.lens_priors;
  }
  single.lens_priors = std::move(priors_of_best);
  return best;
}

// The problem of one camera, which has its views for as long as this lives: thousands of views are not copied.
struct BorrowedCamera {
  CalibrationProblem& whole;
  int camera;
  Subproblem single;

  BorrowedCamera(CalibrationProblem& problem, int which)
      : whole(problem), camera(which), single(take_cameras(problem, {which})) {}
  BorrowedCamera(const BorrowedCamera&) = delete;
  BorrowedCamera& operator=(const BorrowedCamera&) = delete;
  ~BorrowedCamera() {
    for (std::size_t v = 0; v < single.views.size(); ++v) {
      TargetView& view = whole.views[single.views[v]];
      view = std::move(single.problem.views[v]);
      view.camera = camera;
    }
  }
};

void solve_camera_alone(CalibrationProblem& problem, int camera, const CalibrateOptions& options,
                        std::vector<StageTime>& stages, CamerasAlone& alone) {
  BorrowedCamera borrowed(problem, camera);
  Subproblem& single = borrowed.single;
  const CameraStart start = start_of(single.problem, stages);
  const Stopwatch stopwatch(stages, "solve");
  SolvedState solved = solve_from_best(start, single.problem, options);
  win_back_views(single.problem, options, solved);
  settle_lens_priors(single.problem, options, solved);
  CameraOptimum optimum = leave_local_optima(single.problem, options, std::move(solved));
  alone.given_up[camera] = keep_lens_beyond_corners(single.problem, options, optimum);
  const auto& [state, reasons, summary] = optimum.solved;
  alone.summaries[camera] = summary;
  alone.sigmas[camera] = robust_sigmas(single.problem, state)[0];
  std::ranges::copy(single.problem.lens_priors, std::back_inserter(alone.lens_priors));
  if (problem.cameras.size() == 1) refuse_open_lens(single.problem, state, optimum.projection_sigma_px);
  alone.cameras[camera] = state.cameras[0];
  std::vector<std::optional<Rigid3>> mirrored(single.views.size());
  if (problem.cameras.size() > 1) mirrored = mirrored_boards(single.problem, state);
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    const int view = single.views[v];
    alone.reasons[view] = reasons[v];
    alone.fates[view] = state.fates[v];
    if (state.pose_of_view[v] >= 0) alone.camera_from_target[view] = state.poses[state.pose_of_view[v]].rig_from_target;
    alone.mirrored[view] = mirrored[v];
  }
}

}  // namespace

CamerasAlone solve_cameras_alone(CalibrationProblem& problem, const CalibrateOptions& options,
                                 std::vector<StageTime>& stages) {
  CamerasAlone alone;
  alone.cameras.resize(problem.cameras.size());
  alone.summaries.resize(problem.cameras.size());
  alone.sigmas.resize(problem.cameras.size());
  alone.why_not.resize(problem.cameras.size());
  alone.why_aside.resize(problem.cameras.size(), "its camera could not be calibrated");
  alone.given_up.resize(problem.cameras.size());
  alone.camera_from_target.resize(problem.views.size());
  alone.mirrored.resize(problem.views.size());
  alone.fates.resize(problem.views.size());
  alone.reasons.resize(problem.views.size());
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    try {
      solve_camera_alone(problem, c, options, stages, alone);
    } catch (const Error& error) {  // one bad camera never costs a rig
      if (error.kind() != ErrorKind::kNotEnoughData || problem.cameras.size() == 1) throw;
      alone.why_not[c] = error.what();
    }
  }
  return alone;
}

}  // namespace raybundle
