// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "cameras_alone.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <exception>
#include <iterator>
#include <utility>

#include "lens_certainty.hpp"
#include "local_optima.hpp"
#include "lost_views.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/initialize/camera_start.hpp"
#include "robust_solve.hpp"
#include "stopwatch.hpp"
#include "subproblem.hpp"

namespace raybundle {
namespace {

constexpr int kMostWeighings = 4;  // of the prior, until the noise is that of the corners

// Frees coefficients again that were given up, in the problem and in the optimum, where the lens that then fits better
// does not end among its corners: since they were given up, the lens has moved, and other corners may have come into use.
void take_back_coefficients(CalibrationProblem& single, std::size_t own_rules, const CalibrateOptions& options,
                            CameraOptimum& optimum) {
  for (CalibrationProblem fuller = single; fuller.rules.size() > own_rules;) {
    fuller.rules.pop_back();
    SolvedState solved = optimum.solved;
    solved.summary = solve_without_outliers(fuller, solved.state, options, false, solved.reasons);
    if (solved.summary.termination == Termination::kFailed || ends_among_corners(fuller, solved.state, 0)) continue;
    const bool same_corners = solved.state.fates == optimum.solved.state.fates;  // then its cost is lower
    if (!same_corners && !is_better(fuller, solved, optimum.solved, options)) continue;
    optimum = leave_local_optima(fuller, options, std::move(solved));
    single = fuller;
  }
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
  const std::size_t own_rules = single.rules.size();
  // The lens that was replaced may have cost views.
  if (give_second_chance(simpler, solved.state, options, solved.reasons)) solved.summary = solve(simpler, solved.state);
  // With all coefficients there may be such a lens farther away, and a better one.
  CameraOptimum fuller = leave_local_optima(single, options, solved);
  if (simpler.rules.size() == own_rules || is_better(single, fuller.solved, solved, options)) {
    optimum = std::move(fuller);
    return {};
  }
  single = std::move(simpler);
  optimum = leave_local_optima(single, options, std::move(solved));
  take_back_coefficients(single, own_rules, options, optimum);
  return {single.rules.begin() + static_cast<std::ptrdiff_t>(own_rules), single.rules.end()};
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
  double squares_of_best = prior_squares(single, best.state);  // each by its own priors, which its noise weighs
  for (const CameraStart& other : start.others) {
    SolvedState solved = solve_from(other, single, options);
    if (!is_better(single, solved, best, options, squares_of_best)) continue;
    best = std::move(solved);
    squares_of_best = prior_squares(single, best.state);
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

/// A camera on its way through the stages, until one fails.
struct LoneCamera {
  BorrowedCamera borrowed;
  CameraStart start = {};
  CameraOptimum optimum = {};
  std::vector<ParameterRule> given_up = {};
  double sigma = 0.0;                                ///< as in CamerasAlone
  std::vector<std::optional<Rigid3>> mirrored = {};  ///< aligned with its views
  std::exception_ptr failure = {};

  LoneCamera(CalibrationProblem& problem, int camera) : borrowed(problem, camera) {}
  CalibrationProblem& problem() { return borrowed.single.problem; }
};

void solve(LoneCamera& camera, bool of_rig, const CalibrateOptions& options) {
  CalibrationProblem& single = camera.problem();
  SolvedState solved = solve_from_best(camera.start, single, options);
  win_back_views(single, options, solved);
  settle_lens_priors(single, options, solved);
  camera.optimum = leave_local_optima(single, options, std::move(solved));
  camera.given_up = keep_lens_beyond_corners(single, options, camera.optimum);
  const BundleState& state = camera.optimum.solved.state;
  camera.sigma = robust_sigmas(single, state)[0];
  camera.mirrored.resize(single.views.size());
  if (of_rig) camera.mirrored = mirrored_boards(single, camera.optimum, options.threads);
}

// One stage of all cameras. They know nothing of one another: so many threads are shared out among them.
template <typename Work>
void for_each_camera(std::deque<LoneCamera>& cameras, const CalibrateOptions& options, const Work& work) {
  const int side_by_side = std::min(options.threads, static_cast<int>(cameras.size()));
  CalibrateOptions of_one = options;
  of_one.threads = options.threads / side_by_side;
  for_each_index(cameras.size(), side_by_side, [&](std::size_t c) {
    if (cameras[c].failure) return;
    try {
      work(cameras[c], of_one);
    } catch (const Error&) {
      cameras[c].failure = std::current_exception();
    }
  });
}

// Start values that are given may fit no view at all, and a solve without a corner says nothing of its camera.
void refuse_without_corners(LoneCamera& lone) {
  if (std::isfinite(lone.sigma)) return;
  const CalibrationProblem& single = lone.problem();
  const std::string place = "camera " + single.cameras[0].name;
  if (single.views.empty()) throw Error(ErrorKind::kNotEnoughData, "there is no view of the board", place);
  throw Error(ErrorKind::kNotEnoughData,
              fmt::format("none of its {} views fits the lens that it started from, as that of frame {}: {}",
                          single.views.size(), single.frames[single.views[0].frame], lone.optimum.solved.reasons[0]),
              place);
}

/// @throws Error where a stage failed
void take_over(LoneCamera& lone, bool of_rig, CamerasAlone& alone) {
  if (lone.failure) std::rethrow_exception(lone.failure);
  refuse_without_corners(lone);
  const int camera = lone.borrowed.camera;
  const auto& [state, reasons, summary] = lone.optimum.solved;
  if (!of_rig) refuse_open_lens(lone.problem(), state, lone.optimum.projection_sigma_px);
  alone.cameras[camera] = state.cameras[0];
  alone.summaries[camera] = summary;
  alone.sigmas[camera] = lone.sigma;
  alone.given_up[camera] = std::move(lone.given_up);
  std::ranges::copy(lone.problem().lens_priors, std::back_inserter(alone.lens_priors));
  const std::vector<int>& views = lone.borrowed.single.views;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const int view = views[v];
    alone.reasons[view] = reasons[v];
    alone.fates[view] = state.fates[v];
    if (state.pose_of_view[v] >= 0) alone.camera_from_target[view] = state.poses[state.pose_of_view[v]].rig_from_target;
    alone.mirrored[view] = lone.mirrored[v];
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
  const bool of_rig = problem.cameras.size() > 1;
  std::deque<LoneCamera> cameras;
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) cameras.emplace_back(problem, c);
  {
    const Stopwatch stopwatch(stages, "start");
    for_each_camera(cameras, options, [](LoneCamera& camera, const CalibrateOptions& of_one) {
      camera.start = initialize_camera(camera.problem(), 0, of_one.threads);
    });
  }
  const Stopwatch stopwatch(stages, "solve");
  for_each_camera(cameras, options,
                  [&](LoneCamera& camera, const CalibrateOptions& of_one) { solve(camera, of_rig, of_one); });
  for (LoneCamera& camera : cameras) {
    try {
      take_over(camera, of_rig, alone);
    } catch (const Error& error) {  // one bad camera never costs a rig
      if (error.kind() != ErrorKind::kNotEnoughData || !of_rig) throw;
      alone.why_not[camera.borrowed.camera] = error.what();
    }
  }
  return alone;
}

}  // namespace raybundle
