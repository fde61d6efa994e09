// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/calibrate.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "raybundle/geometry/error.hpp"
#include "raybundle/initialize/camera_start.hpp"
#include "raybundle/initialize/rig_start.hpp"
#include "raybundle/uncertainty/covariance.hpp"
#include "robust_solve.hpp"
#include "subproblem.hpp"
#include "summary.hpp"
#include "ties.hpp"

namespace raybundle {
namespace {

// Runs a stage of the pipeline and adds its time to the result.
template <typename Stage>
decltype(auto) timed(CalibrationResult& result, const std::string& name, Stage&& stage) {
  struct Stopwatch {
    CalibrationResult& result;
    const std::string& name;
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    ~Stopwatch() {
      auto found = std::ranges::find(result.stages, name, &StageTime::name);
      if (found == result.stages.end()) found = result.stages.insert(found, {name, 0.0});
      found->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
  } stopwatch{result, name};
  return stage();
}

// What each camera tells by itself. Vectors are aligned with the problem's cameras and views.
struct CamerasAlone {
  std::vector<std::optional<Camera>> cameras;  // empty where the views do not determine one
  std::vector<std::string> why_not;
  std::vector<std::optional<Rigid3>> camera_from_target;
  std::vector<std::string> reasons;  // why a view has no pose
};

// One camera by itself: start without a focal guess, then a robust solve; views that did not fit get a second chance.
void solve_camera_alone(const CalibrationProblem& problem, int camera, const CalibrateOptions& options,
                        CalibrationResult& result, CamerasAlone& alone) {
  const Subproblem single = select_cameras(problem, {camera});
  const CameraStart start = timed(result, "start", [&] { return initialize_camera(single.problem, 0); });
  BundleState state = state_from_start(single.problem, start);
  std::vector<std::string> reasons = start.reasons;
  timed(result, "solve", [&] {
    solve_robustly(single.problem, state, options);
    give_second_chance(single.problem, state, reasons);
    solve_robustly(single.problem, state, options);
  });
  alone.cameras[camera] = state.cameras[0];
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    alone.reasons[single.views[v]] = reasons[v];
    if (state.pose_of_view[v] < 0) continue;
    alone.camera_from_target[single.views[v]] = state.poses[state.pose_of_view[v]].rig_from_target;
  }
}

CamerasAlone solve_cameras_alone(const CalibrationProblem& problem, const CalibrateOptions& options,
                                 CalibrationResult& result) {
  CamerasAlone alone;
  alone.cameras.resize(problem.cameras.size());
  alone.why_not.resize(problem.cameras.size());
  alone.camera_from_target.resize(problem.views.size());
  alone.reasons.resize(problem.views.size());
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    try {
      solve_camera_alone(problem, c, options, result, alone);
    } catch (const Error& error) {  // one bad camera never costs a rig
      if (error.kind() != ErrorKind::kNotEnoughData || problem.cameras.size() == 1) throw;
      alone.why_not[c] = error.what();
    }
  }
  return alone;
}

BundleState rig_state(const CalibrationProblem& problem, const CamerasAlone& alone, const std::vector<int>& cameras,
                      const RigStart& rig) {
  BundleState state;
  for (int c : cameras) state.cameras.push_back(*alone.cameras[c]);
  state.camera_from_rig = rig.camera_from_rig;
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    if (problem.cameras[c].camera_from_rig) state.camera_from_rig[c] = *problem.cameras[c].camera_from_rig;
  }
  state.poses = rig.poses;
  state.pose_of_view = rig.pose_of_view;
  state.shapes.resize(problem.targets.size());
  mark_projectable(problem, state);
  return state;
}

// Sum of squared whitened residuals of the corners that both states use.
double chi2_in_common(const CalibrationProblem& problem, const BundleState& state, const BundleState& other,
                      double& corners) {
  double chi2 = corners = 0.0;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (state.pose_of_view[v] < 0 || other.pose_of_view[v] < 0) continue;
    const std::vector<Eigen::Vector2d> residuals = view_residuals(problem, state, v);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const bool both = state.fates[v][i] == ObservationFate::kUsed && other.fates[v][i] == ObservationFate::kUsed;
      if (!both) continue;
      const double sigma = problem.views[v].observations[i].sigma_px;
      chi2 += residuals[i].squaredNorm() / (sigma * sigma);
      corners += 1.0;
    }
  }
  return chi2;
}

// A bent board must lower the squared residuals by 2 % (the rms by 1 %) and, as an F-test, by 20 per parameter: far
// beyond chance (99.9 % of F(3, n) lies below 5.5) because corner errors are not independent.
bool data_carry_shape(const CalibrationProblem& problem, const BundleState& flat, const BundleState& bent) {
  double corners = 0.0;
  const double chi2_flat = chi2_in_common(problem, flat, bent, corners);
  const double chi2_bent = chi2_in_common(problem, bent, flat, corners);
  const double gain = chi2_flat - chi2_bent;
  const double parameters = 3.0 * static_cast<double>(problem.targets.size());
  return gain > 0.02 * chi2_flat && gain / parameters > 20.0 * chi2_bent / (2.0 * corners);
}

struct JointSolve {
  BundleSummary summary;
  std::vector<SetAside> untied;
  bool shape_estimated = false;
};

constexpr int kMaxTieReviews = 8;

JointSolve solve_jointly(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                         std::vector<std::string>& reasons) {
  solve_robustly(problem, state, options);
  JointSolve solve;
  for (int round = 0; round < kMaxTieReviews; ++round) {
    give_second_chance(problem, state, reasons);
    if (!review_ties(problem, state, options, solve.untied) && round > 0) break;
    solve.summary = solve_without_outliers(problem, state, options, false, reasons);
  }
  const bool flat_board = std::ranges::any_of(problem.targets, &Target::flat);
  if (options.estimate_shape && flat_board && solve.summary.termination != Termination::kFailed) {
    BundleState bent = state;
    std::vector<std::string> bent_reasons = reasons;
    const BundleSummary summary = solve_without_outliers(problem, bent, options, true, bent_reasons);
    if (summary.termination != Termination::kFailed && data_carry_shape(problem, state, bent)) {
      solve.summary = summary;
      solve.shape_estimated = true;
      state = bent;
      reasons = bent_reasons;
    }
  }
  if (solve.summary.termination == Termination::kFailed) {
    throw Error(ErrorKind::kSolveFailed, "the bundle adjustment broke down: " + solve.summary.message);
  }
  return solve;
}

void fill_covariance(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options,
                     CalibrationResult& result) {
  const CovarianceResult known = covariance(reduced_information(problem, state, options));
  result.calibration.covariance = known.covariance;
  result.variance_factor = known.variance_factor;
  if (known.weak_parameters.empty()) return;
  std::string weak;
  for (const std::string& name : known.weak_parameters) weak += (weak.empty() ? "" : ", ") + name;
  result.warnings.push_back("the views hardly tell these parameters apart: " + weak +
                            "; add views with the board tilted, near and far, and in the corners of the image");
}

void name_views_set_aside(const BundleState& state, const std::vector<std::string>& reasons,
                          CalibrationResult& result) {
  for (std::size_t v = 0; v < state.pose_of_view.size(); ++v) {
    if (state.pose_of_view[v] >= 0) continue;
    result.set_aside.push_back({static_cast<int>(v), SetAside::Scope::kView, reasons[v]});
  }
}

// The result of a problem without its undetermined cameras, as a result of the whole problem.
CalibrationResult for_whole_problem(const CalibrationProblem& whole, const std::vector<int>& cameras,
                                    const Subproblem& sub, const CamerasAlone& alone, CalibrationResult result) {
  std::vector<CameraSummary> summaries(whole.cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) summaries[cameras[c]] = result.cameras[c];
  std::vector<ViewResult> views(whole.views.size());
  for (std::size_t v = 0; v < sub.views.size(); ++v) views[sub.views[v]] = std::move(result.views[v]);
  for (SetAside& aside : result.set_aside) aside.view = sub.views[aside.view];
  for (std::size_t v = 0; v < whole.views.size(); ++v) {
    const int camera = whole.views[v].camera;
    if (alone.cameras[camera]) continue;
    const std::size_t count = whole.views[v].observations.size();
    views[v].fates.assign(count, ObservationFate::kViewSetAside);
    views[v].residuals_px.assign(count, Eigen::Vector2d::Constant(std::nan("")));
    summaries[camera].views_total += 1;
    result.set_aside.push_back({static_cast<int>(v), SetAside::Scope::kView, "its camera could not be calibrated"});
  }
  for (std::size_t c = 0; c < whole.cameras.size(); ++c) {
    if (!alone.cameras[c]) result.warnings.push_back("camera " + whole.cameras[c].name + ": " + alone.why_not[c]);
  }
  result.cameras = std::move(summaries);
  result.views = std::move(views);
  return result;
}

}  // namespace

CalibrationResult calibrate(const CalibrationProblem& problem, const CalibrateOptions& options) {
  check(problem);
  CalibrationResult result;

  // Each camera alone, then all that could be calibrated as one rig.
  const CamerasAlone alone = solve_cameras_alone(problem, options, result);
  std::vector<int> cameras;
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    if (alone.cameras[c]) cameras.push_back(c);
  }
  if (cameras.empty()) throw Error(ErrorKind::kNotEnoughData, alone.why_not.front());
  Subproblem sub = select_cameras(problem, cameras);
  if (cameras.size() == problem.cameras.size()) sub.problem.rules = problem.rules;  // so that none goes unheard
  std::vector<std::optional<Rigid3>> camera_from_target;
  std::vector<std::string> reasons;
  for (int v : sub.views) {
    camera_from_target.push_back(alone.camera_from_target[v]);
    reasons.push_back(alone.reasons[v]);
  }
  const RigStart rig = timed(result, "start", [&] { return initialize_rig(sub.problem, camera_from_target); });
  sub.problem = relabelled(sub.problem, rig.symmetry_of_view);

  // One bundle for everything.
  BundleState state = rig_state(sub.problem, alone, cameras, rig);
  const JointSolve solve = timed(result, "solve", [&] { return solve_jointly(sub.problem, state, options, reasons); });
  BundleOptions bundle;
  bundle.estimate_shape = solve.shape_estimated;
  timed(result, "uncertainty", [&] { fill_covariance(sub.problem, state, bundle, result); });

  fill_result(sub.problem, state, result);
  result.set_aside = solve.untied;
  name_views_set_aside(state, reasons, result);
  result.termination = solve.summary.termination;
  result.iterations = solve.summary.iterations;
  result.outlier_rule = outlier_rule(options);
  result.gauge = "the rig frame is the frame of camera " + sub.problem.cameras.front().name +
                 "; the scale comes from the size of the board";
  if (result.termination == Termination::kIterationLimit) {
    result.warnings.push_back("the solve stopped at the limit of iterations before it converged");
  }
  return for_whole_problem(problem, cameras, sub, alone, std::move(result));
}

}  // namespace raybundle
