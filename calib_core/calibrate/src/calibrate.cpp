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
#include "kept_values.hpp"
#include "prior_weight.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/calibrate/data_warnings.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/camera/injectivity.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/initialize/rig_start.hpp"
#include "rig_problem.hpp"
#include "robust_solve.hpp"
#include "stopwatch.hpp"
#include "subproblem.hpp"
#include "summary.hpp"

namespace raybundle {
namespace {

RigStart start_of(const RigProblem& rig, std::vector<StageTime>& stages) {
  const Stopwatch stopwatch(stages, "start");
  return initialize_rig(rig.sub.problem, rig.camera_from_target, rig.mirrored);
}

BundleState state_of(const RigProblem& rig, const RigStart& start, const CamerasAlone& alone) {
  const CalibrationProblem& problem = rig.sub.problem;
  BundleState state;
  for (const int c : rig.cameras) state.cameras.push_back(*alone.cameras[c]);
  state.camera_from_rig = start.camera_from_rig;
  for (std::size_t c = 1; c < rig.cameras.size(); ++c) {
    if (problem.cameras[c].camera_from_rig) state.camera_from_rig[c] = *problem.cameras[c].camera_from_rig;
  }
  state.poses = start.poses;
  state.pose_of_view = start.pose_of_view;
  state.shapes.resize(problem.targets.size());
  state.fates = rig.fates;
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

// What the cameras tell together, or a board that may bend, may move a lens so that it ends among its corners. Simpler
// ones are tried with the ties and the boards as they are.
void keep_lenses_beyond_corners(CalibrationProblem& problem, const CalibrateOptions& options,
                                const std::vector<double>& sigmas_alone, JointSolve& solve) {
  SolvedState& solved = solve.solved;
  std::vector<std::string> reasons;  // of the trials
  const auto solve_again = [&](const CalibrationProblem& simpler, BundleState& state) {
    BundleOptions bundle = bundle_options(options);
    bundle.estimate_shape = solve.shape_estimated;
    const BundleSummary of_same_corners = solve_bundle(simpler, state, bundle);
    return solve_without_outliers(simpler, state, options, solve.shape_estimated, reasons, of_same_corners);
  };
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    reasons = solved.reasons;
    if (!give_up_coefficients(problem, solved.state, c, solved.summary, solve_again)) continue;
    solved.reasons = reasons;
    if (problem.cameras.size() > 1) solve = solve_jointly(problem, options, sigmas_alone, solved);
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
CalibrationResult for_whole_problem(const CalibrationProblem& whole, const RigProblem& rig, const CamerasAlone& alone,
                                    CalibrationResult result) {
  const Subproblem& sub = rig.sub;
  std::vector<CameraSummary> summaries(whole.cameras.size());
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) summaries[rig.cameras[c]] = result.cameras[c];
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
  const bool new_frame_known = whole.cameras[rig.cameras.front()].camera_from_rig.has_value();
  for (const ParameterRule& rule : whole.rules) {
    if (rig.cameras.front() == 0 || !bound_to_frame(rule, new_frame_known)) continue;
    result.warnings.push_back(fmt::format("{} is not used: it is given as seen from camera {}, which is left out",
                                          rule.pattern, whole.cameras.front().name));
  }
  result.cameras = std::move(summaries);
  result.views = std::move(views);
  return result;
}

// Of what the solve of the rig leaves doubtful.
void add_warnings(const RigProblem& rig, const BundleState& state, const Ties& ties, const std::string& message,
                  CalibrationResult& result) {
  const CalibrationProblem& problem = rig.sub.problem;
  name_given_up(problem, rig.own_rules, result);
  warn_of_folds(problem, state, result);
  std::ranges::copy(contradicted_priors(problem, state, result), std::back_inserter(result.warnings));
  if (ties.rule.unsynchronised) {
    result.warnings.push_back(
        "even the frames that link the cameras fit them worse together than apart: they did not expose at the same "
        "moment, or the board was moving; hold it still or synchronise the cameras, and trust the sigmas less");
  }
  if (result.termination == Termination::kIterationLimit) {
    result.warnings.push_back("the solve stopped at the limit of iterations before it converged");
  }
  if (result.termination == Termination::kBlocked) {
    result.warnings.push_back("the solve ended before the optimum: " + message +
                              "; choose another model for that camera, or leave that image out");
  }
}

// All cameras that could be calibrated alone, as one rig.
//
// @param stages  the times of what went before
CalibrationResult calibrate_together(CalibrationProblem whole, const CamerasAlone& alone,
                                     const CalibrateOptions& options, const std::vector<StageTime>& stages) {
  CalibrationResult result;
  result.stages = stages;
  RigProblem rig = rig_problem(whole, alone);
  CalibrationProblem& problem = rig.sub.problem;
  const RigStart start = start_of(rig, result.stages);
  relabel(problem, start.symmetry_of_view);

  // One bundle for everything.
  JointSolve solve;
  {
    const Stopwatch stopwatch(result.stages, "solve");
    SolvedState begin{state_of(rig, start, alone), rig.reasons, alone.summaries[rig.cameras.front()]};
    solve = solve_jointly(problem, options, rig.sigmas_alone, std::move(begin));
    keep_lenses_beyond_corners(problem, options, rig.sigmas_alone, solve);
  }
  BundleState& state = solve.solved.state;
  BundleOptions bundle;
  bundle.estimate_shape = solve.shape_estimated;
  bundle.threads = options.threads;
  {
    const Stopwatch stopwatch(result.stages, "uncertainty");
    fill_covariance(problem, state, bundle, result);
  }
  result.termination = solve.solved.summary.termination;
  result.iterations = solve.solved.summary.iterations;

  std::vector<std::optional<CornerEvidence>> evidence;
  add_further_measurements(options, bundle, problem, state, result, evidence);

  fill_result(problem, state, result);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    result.calibration.cameras[c].evidence = evidence[c];
    result.cameras[c].sigma_scale = rig.sigma_scales[c];
  }
  for (std::size_t v = 0; v < rig.sub.views.size(); ++v) result.views[v].symmetry = start.symmetry_of_view[v];
  add_warnings(rig, state, solve.ties, solve.solved.summary.message, result);
  std::ranges::copy_if(solve.ties.review.untied, std::back_inserter(result.set_aside),
                       [&](const SetAside& untied) { return state.pose_of_view[untied.view] >= 0; });
  name_views_set_aside(state, solve.solved.reasons, result);
  result.lens_priors = lens_priors_in_force(problem);
  result.outlier_rule = outlier_rule(options);
  result.gauge = "the rig frame is the frame of camera " + problem.cameras.front().name +
                 "; the scale comes from the size of the board";
  return for_whole_problem(whole, rig, alone, std::move(result));
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

// A prior counts against corners by what they are off by, not by what a detector says; and that is known only after
// a solve. The least noise counts: where a prior pulls too hard there is more.
CalibrationResult calibrate_weighing_priors(const CalibrationProblem& problem, const CalibrateOptions& options) {
  CalibrationResult result = calibrate_as_weighed(problem, options);
  if (!has_priors(problem)) return result;
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

// What corners say of values that are kept against them.
std::vector<std::string> contradicted_values(const CalibrationProblem& problem, const CalibrateOptions& options,
                                             const CalibrationResult& result) {
  if (!keeps_values(problem) && !has_priors(problem)) return {};  // before thousands of views are copied
  const CalibrationProblem kept = with_overruling_priors_kept(problem, result);
  if (!keeps_values(kept)) return {};
  const CalibrationProblem freed = without_kept_values(kept);
  try {
    return contradictions(kept, result, freed, calibrate_weighing_priors(freed, options));
  } catch (const Error&) {  // the data do not determine what was given
    return {};
  }
}

}  // namespace

void check(const CalibrateOptions& options, const std::string& where) {
  CalibrateOptions::for_each_option(
      options, [&]<typename T>(std::string_view name, const char*, const char*, const T& value) {
        if constexpr (!std::is_same_v<T, bool>) {
          if (value > 0 && std::isfinite(static_cast<double>(value)) && (name != "threads" || value <= kMostThreads)) {
            return;
          }
          throw Error(ErrorKind::kBadInput,
                      name == "threads" ? fmt::format("threads is {}, but must be 1 to {}", value, kMostThreads)
                                        : fmt::format("{} is {}, but must be a positive number", name, value),
                      where);
        }
      });
}

CalibrationResult calibrate(const CalibrationProblem& problem, const CalibrateOptions& options) {
  check(options);
  check(problem);
  require_values(problem);  // refuses rules that match nothing, too
  CalibrationResult result = calibrate_weighing_priors(problem, options);
  std::ranges::move(contradicted_values(problem, options, result), std::back_inserter(result.warnings));
  std::ranges::move(data_warnings(problem, result), std::back_inserter(result.warnings));
  return result;
}

}  // namespace raybundle
