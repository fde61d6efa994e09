// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "cameras_alone.hpp"
#include "content_order.hpp"
#include "further_measurements.hpp"
#include "joint_solve.hpp"
#include "prior_weight.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/camera/injectivity.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/initialize/rig_start.hpp"
#include "robust_solve.hpp"
#include "stopwatch.hpp"
#include "subproblem.hpp"
#include "summary.hpp"

namespace raybundle {
namespace {

RigStart rig_start(const CalibrationProblem& problem, const std::vector<std::optional<Rigid3>>& camera_from_target,
                   const std::vector<std::optional<Rigid3>>& mirrored, std::vector<StageTime>& stages) {
  const Stopwatch stopwatch(stages, "start");
  return initialize_rig(problem, camera_from_target, mirrored);
}

BundleState rig_state(const CalibrationProblem& problem, const CamerasAlone& alone, const std::vector<int>& cameras,
                      const RigStart& rig, const std::vector<std::vector<ObservationFate>>& fates) {
  BundleState state;
  for (int c : cameras) state.cameras.push_back(*alone.cameras[c]);
  state.camera_from_rig = rig.camera_from_rig;
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    if (problem.cameras[c].camera_from_rig) state.camera_from_rig[c] = *problem.cameras[c].camera_from_rig;
  }
  state.poses = rig.poses;
  state.pose_of_view = rig.pose_of_view;
  state.shapes.resize(problem.targets.size());
  state.fates = fates;
  mark_projectable(problem, state);
  return state;
}

std::string fold_warning(const std::string& camera, const InjectivityReport& report) {
  return fmt::format(
      "camera {}: the projection is one-to-one only up to {:.1f} degrees off the axis: {:.1f} % of the image, from pixel "
      "({:.0f}, {:.0f}) outwards, has no ray; harmless outside of a fisheye's image circle, otherwise show boards "
      "there or take a model for wider lenses such as kannala_brandt, or one with fewer parameters",
      camera, report.max_angle_rad * 180.0 / M_PI, 100.0 * (1.0 - report.covered_fraction), report.first_offender->x(),
      report.first_offender->y());
}

// A lens that folds beyond the corners is an ordinary fisheye with its image circle; one that folds among them is
// wrong.
void warn_of_folds(const CalibrationProblem& problem, const BundleState& state, CalibrationResult& result) {
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    const Camera& camera = state.cameras[c];
    double farthest_px = 0.0;
    for (std::size_t v = 0; v < problem.views.size(); ++v) {
      if (problem.views[v].camera != c || state.pose_of_view[v] < 0) continue;
      for (std::size_t i = 0; i < state.fates[v].size(); ++i) {
        if (state.fates[v][i] != ObservationFate::kUsed) continue;
        const Eigen::Vector2d offset =
            problem.views[v].observations[i].pixel - Eigen::Vector2d(camera.cx(), camera.cy());
        farthest_px = std::max(farthest_px, offset.norm());
      }
    }
    const InjectivityReport report = check_injectivity(camera);
    if (report.one_to_one() || report.first_offender_radius_px > farthest_px) continue;
    result.warnings.push_back(fold_warning(problem.cameras[c].name, report));
  }
}

// What the cameras tell together may bend a lens so that it ends among its corners.
void keep_lenses_beyond_corners(CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                                const std::vector<double>& sigmas_alone, std::vector<std::string>& reasons,
                                JointSolve& solve) {
  const auto solve_again = [&](const CalibrationProblem& simpler, BundleState& of_simpler) {
    return solve_jointly(simpler, of_simpler, options, sigmas_alone, reasons).summary;
  };
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    if (!give_up_coefficients(problem, state, c, solve.summary, solve_again)) continue;
    solve = solve_jointly(problem, state, options, sigmas_alone, reasons, solve.summary);
  }
}

// Tells which coefficients are held at zero because their lens would end among its corners: of the rules from `first`
// on.
void name_given_up(const CalibrationProblem& problem, std::size_t first, CalibrationResult& result) {
  std::string names;
  for (std::size_t i = first; i < problem.rules.size(); ++i)
    names += (i > first ? ", " : "") + problem.rules[i].pattern;
  if (names.empty()) return;
  result.warnings.push_back("held at zero: " + names +
                            "; otherwise the lens that fits best has a pole among the corners or shortly beyond them, "
                            "or turns back there; choose a model with fewer "
                            "parameters, or add views that fill the image");
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
    views[v].beam_of_dot.assign(whole.views[v].dots.size(), kUnlabelled);
    views[v].dot_fates.assign(whole.views[v].dots.size(), ObservationFate::kViewSetAside);
    views[v].dot_residuals_px.assign(whole.views[v].dots.size(), Eigen::Vector2d::Constant(std::nan("")));
    views[v].residuals_px.assign(count, Eigen::Vector2d::Constant(std::nan("")));
    summaries[camera].views_total += 1;
    result.set_aside.push_back({static_cast<int>(v), SetAside::Scope::kView, alone.why_aside[camera]});
  }
  for (std::size_t c = 0; c < whole.cameras.size(); ++c) {
    if (!alone.cameras[c]) result.warnings.push_back(alone.why_not[c]);
  }
  result.cameras = std::move(summaries);
  result.views = std::move(views);
  return result;
}

// All cameras that could be calibrated alone, as one rig.
//
// @param stages  the times of what went before
CalibrationResult calibrate_together(CalibrationProblem problem, const CamerasAlone& alone,
                                     const CalibrateOptions& options, const std::vector<StageTime>& stages) {
  CalibrationResult result;
  result.stages = stages;
  std::vector<int> cameras;
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    if (alone.cameras[c]) cameras.push_back(c);
  }
  if (cameras.empty()) throw Error(ErrorKind::kNotEnoughData, alone.why_not.front());
  Subproblem sub = take_cameras(problem, cameras);
  const std::size_t rules = sub.problem.rules.size();
  for (const int c : cameras) std::ranges::copy(alone.given_up[c], std::back_inserter(sub.problem.rules));
  sub.problem.lens_priors = alone.lens_priors;
  std::vector<std::optional<Rigid3>> camera_from_target, mirrored;
  std::vector<std::vector<ObservationFate>> fates;
  std::vector<std::string> reasons;
  std::vector<double> sigmas_alone;
  for (const int c : cameras) sigmas_alone.push_back(alone.sigmas[c]);
  for (int v : sub.views) {
    fates.push_back(alone.fates[v]);
    camera_from_target.push_back(alone.camera_from_target[v]);
    mirrored.push_back(alone.mirrored[v]);
    reasons.push_back(alone.reasons[v]);
  }
  const RigStart rig = rig_start(sub.problem, camera_from_target, mirrored, result.stages);
  relabel(sub.problem, rig.symmetry_of_view);

  // One bundle for everything.
  BundleState state = rig_state(sub.problem, alone, cameras, rig, fates);
  JointSolve solve;
  {
    const Stopwatch stopwatch(result.stages, "solve");
    solve = solve_jointly(sub.problem, state, options, sigmas_alone, reasons, alone.summaries[cameras.front()]);
    keep_lenses_beyond_corners(sub.problem, state, options, sigmas_alone, reasons, solve);
  }
  BundleOptions bundle;
  bundle.estimate_shape = solve.shape_estimated;
  bundle.threads = options.threads;
  {
    const Stopwatch stopwatch(result.stages, "uncertainty");
    fill_covariance(sub.problem, state, bundle, result);
  }
  result.termination = solve.summary.termination;
  result.iterations = solve.summary.iterations;

  std::vector<std::optional<CornerEvidence>> evidence;
  add_further_measurements(options, bundle, sub.problem, state, result, evidence);

  fill_result(sub.problem, state, result);
  for (std::size_t c = 0; c < cameras.size(); ++c) result.calibration.cameras[c].evidence = evidence[c];
  for (std::size_t v = 0; v < sub.views.size(); ++v) result.views[v].symmetry = rig.symmetry_of_view[v];
  name_given_up(sub.problem, rules, result);
  warn_of_folds(sub.problem, state, result);
  std::ranges::copy(contradicted_priors(sub.problem, state, result), std::back_inserter(result.warnings));
  std::ranges::copy_if(solve.ties.untied, std::back_inserter(result.set_aside),
                       [&](const SetAside& untied) { return state.pose_of_view[untied.view] >= 0; });
  name_views_set_aside(state, reasons, result);
  result.lens_priors = lens_priors_in_force(sub.problem);
  result.outlier_rule = outlier_rule(options);
  result.gauge = "the rig frame is the frame of camera " + sub.problem.cameras.front().name +
                 "; the scale comes from the size of the board";
  if (solve.ties.unsynchronised) {
    result.warnings.push_back(
        "in most frames the cameras saw the board in different places: they did not expose at the same moment, or the "
        "board was moving; hold it still or synchronise the cameras, and trust the sigmas less");
  }
  if (result.termination == Termination::kIterationLimit) {
    result.warnings.push_back("the solve stopped at the limit of iterations before it converged");
  }
  return for_whole_problem(problem, cameras, sub, alone, std::move(result));
}

// Whether a camera sees a board in a frame in which another one sees it, too.
bool shares_boards(const CalibrationProblem& problem, int camera) {
  return std::ranges::any_of(problem.views, [&](const TargetView& mine) {
    return mine.camera == camera && std::ranges::any_of(problem.views, [&](const TargetView& other) {
             return other.camera != camera && other.frame == mine.frame && other.target == mine.target;
           });
  });
}

// Leaves out a camera that is calibrated, but has no place on the rig.
void leave_out(const CalibrationProblem& problem, int camera, const Error& refusal, CamerasAlone& alone) {
  const std::string name = "camera " + problem.cameras[camera].name;
  alone.cameras[camera].reset();
  if (shares_boards(problem, camera)) {
    alone.why_not[camera] = name + " is left out, because with it " + refusal.what() +
                            ", or calibrate it in a run of its own, with only its images";
    alone.why_aside[camera] = "its camera could not be linked to the others";
  } else {
    alone.why_not[camera] = name +
                            " is left out: in no frame does it see a board together with another camera, so that "
                            "nothing tells its place on the rig; add images in which they see the board at the same "
                            "moment, or calibrate it in a run of its own, with only its images";
    alone.why_aside[camera] = "its camera shares no frame with the others";
  }
}

// Of three cameras or more, one whose images are of other moments does not cost the rig: the rest is calibrated
// without it. Nothing when no camera is such.
std::optional<CalibrationResult> calibrate_without_one(const CalibrationProblem& problem, const CamerasAlone& alone,
                                                       const CalibrateOptions& options,
                                                       const std::vector<StageTime>& stages, const Error& refusal) {
  if (problem.cameras.size() < 3 || refusal.kind() != ErrorKind::kNotEnoughData) return std::nullopt;
  const OrderedProblem ordered = in_order_of_content(problem);
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    CamerasAlone others = alone;
    leave_out(problem, static_cast<int>(c), refusal, others);
    try {
      return in_given_order(ordered, calibrate_together(ordered.problem, others, options, stages));
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kNotEnoughData) throw;
    }
  }
  return std::nullopt;
}

CalibrationResult calibrate_as_weighed(const CalibrationProblem& problem, const CalibrateOptions& options) {
  OrderedProblem ordered = in_order_of_content(problem);
  std::vector<StageTime> stages;
  const CamerasAlone alone = solve_cameras_alone(ordered.problem, options, stages);
  try {
    return in_given_order(ordered, calibrate_together(std::move(ordered.problem), alone, options, stages));
  } catch (const Error& refusal) {
    if (auto result = calibrate_without_one(problem, alone, options, stages, refusal)) return std::move(*result);
    throw;
  }
}

}  // namespace

CalibrationResult calibrate(const CalibrationProblem& problem, const CalibrateOptions& options) {
  check(problem);
  parameter_blocks(problem);  // refuses rules that match nothing
  CalibrationResult result = calibrate_as_weighed(problem, options);
  if (!has_priors(problem)) return result;
  // A prior counts against corners by what they are off by, not by what a detector says; and that is known only now.
  // The least noise counts: where a prior pulls too hard there is more.
  constexpr int kMostWeighings = 4;
  constexpr double kSettled = 0.98;
  double noise = 1.0;
  for (int round = 0; round < kMostWeighings; ++round) {
    const double now = corner_noise(problem, result);
    if (round == 0 ? std::abs(now - noise) < (1.0 - kSettled) : now > kSettled * noise) break;
    noise = now;
    std::vector<StageTime> stages = std::move(result.stages);
    result = calibrate_as_weighed(with_priors_for(problem, noise), options);
    result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  }
  return result;
}

}  // namespace raybundle
