// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "start_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "projection.hpp"
#include "raybundle/bundle/information.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/uncertainty/covariance.hpp"

namespace raybundle::testing {
namespace {

constexpr double kSameCost = 1e-6;         ///< relative
constexpr double kFewestRightKept = 0.98;  ///< of the right corners; the outlier rule costs 4 in a million

BundleState state_of(const CalibrationResult& result) {
  BundleState state;
  state.cameras.push_back(result.calibration.cameras[0].camera);
  state.camera_from_rig.resize(1);
  state.poses = result.poses;
  state.shapes.push_back(result.calibration.targets[0].shape);
  for (const ViewResult& view : result.views) {
    state.pose_of_view.push_back(view.pose);
    state.fates.push_back(view.fates);
  }
  return state;
}

/// A problem that may hold coefficients at zero, and its optimum.
struct Optimum {
  CalibrationProblem problem;
  BundleState state;
  BundleSummary summary;
};

BundleSummary solve_to_the_end(const CalibrationProblem& problem, BundleState& state, bool estimate_shape = false) {
  BundleOptions options;
  options.estimate_shape = estimate_shape;
  options.max_iterations = 500;
  return solve_bundle(problem, state, options);
}

/// The rig's problem with the prior that calibrate() gives a rational lens by the noise and field of a state.
CalibrationProblem with_lens_prior(const RandomRig& rig, const BundleState& state) {
  CalibrationProblem problem = rig.problem;
  weigh_lens_priors(problem, state);
  return problem;
}

/// The rig's problem with the priors of an answer; those of coefficients that it gave up, which are in force for a lens
/// that has them, stand with the others. k4 to k6 have the priors of k1 to k3.
CalibrationProblem with_priors_of(const RandomRig& rig, const BundleState& answer,
                                  const std::vector<ParameterRule>& in_force) {
  CalibrationProblem problem = with_lens_prior(rig, answer);
  for (ParameterRule& prior : problem.lens_priors) {
    std::string alike = prior.pattern;
    if (alike.back() >= '4' && alike.back() <= '6') alike.back() = static_cast<char>(alike.back() - 3);
    for (const std::string& name : {alike, prior.pattern}) {
      const auto known = std::ranges::find(in_force, name, &ParameterRule::pattern);
      if (known != in_force.end()) prior.sigma = known->sigma;
    }
  }
  return problem;
}

/// Where a solve ends that starts from the truth. Lenses that end among their corners are left as calibrate() leaves
/// them.
Optimum optimum_from_truth(const CalibrationProblem& with_prior, const BundleState& start,
                           bool estimate_shape = false) {
  Optimum optimum{with_prior, start, {}};
  // Giving up coefficients begins with a lens that may not project all corners, and leaves those out: an optimum of
  // fewer corners is lower and proves nothing.
  const auto solve = [&](const CalibrationProblem& problem, BundleState& state) {
    BundleSummary summary = solve_to_the_end(problem, state, estimate_shape);
    if (state.fates == start.fates) return summary;
    state.fates = start.fates;
    return solve_to_the_end(problem, state, estimate_shape);
  };
  optimum.summary = solve(optimum.problem, optimum.state);
  give_up_coefficients(optimum.problem, optimum.state, 0, optimum.summary, solve);
  return optimum;
}

/// Rays of the right corners through the true camera.
std::vector<Eigen::Vector3d> right_rays(const RandomRig& rig) {
  std::vector<Eigen::Vector3d> rays;
  for (std::size_t v = 0; v < rig.problem.views.size(); ++v) {
    const TargetView& view = rig.problem.views[v];
    for (std::size_t i = 0; i < view.observations.size(); ++i) {
      if (rig.truth.fates[v][i] != ObservationFate::kUsed) continue;
      const TargetPoint* point = rig.problem.targets[0].find(view.observations[i].point_id);
      rays.push_back((rig.truth.poses[v].rig_from_target * point->x_in_target).normalized());
    }
  }
  return rays;
}

bool bent(const BoardShape& shape) { return shape.sags() != Eigen::Vector3d::Zero(); }

/// Whether a view's right corners lie on one line of the board, which leaves its pose open.
bool on_one_line(const RandomRig& rig, std::size_t v) {
  const TargetView& view = rig.problem.views[v];
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    if (rig.truth.fates[v][i] != ObservationFate::kUsed) continue;
    points.push_back(rig.problem.targets[0].find(view.observations[i].point_id)->x_in_target);
  }
  for (const Eigen::Vector3d& a : points) {
    for (const Eigen::Vector3d& b : points) {
      const Eigen::Vector3d side = a - points.front(), other = b - points.front();
      if (side.cross(other).norm() > 1e-6 * side.norm() * other.norm()) return false;
    }
  }
  return true;
}

bool may_have_pose(const RandomRig& rig, std::size_t v) {
  return std::ranges::count(rig.truth.fates[v], ObservationFate::kUsed) >= 4 && !on_one_line(rig, v);
}

/// Whether an answer must use the view: one that is wrong for the most part, or whose corners lie on one line, may go.
bool must_be_used(const RandomRig& rig, std::size_t v) {
  const std::vector<ObservationFate>& fates = rig.truth.fates[v];
  const auto right = static_cast<std::size_t>(std::ranges::count(fates, ObservationFate::kUsed));
  return may_have_pose(rig, v) && 2 * right > fates.size() + 1;
}

/// Share of the right corners that an answer uses, of the views that it must use.
double right_kept(const RandomRig& rig, const BundleState& answer) {
  double right = 0.0, kept = 0.0;
  for (std::size_t v = 0; v < rig.truth.fates.size(); ++v) {
    const std::vector<ObservationFate>& fates = rig.truth.fates[v];
    if (!must_be_used(rig, v)) continue;
    right += static_cast<double>(std::ranges::count(fates, ObservationFate::kUsed));
    for (std::size_t i = 0; i < fates.size(); ++i) {
      kept += fates[i] == ObservationFate::kUsed && answer.fates[v][i] == ObservationFate::kUsed;
    }
  }
  return right > 0 ? kept / right : 1.0;
}

/// What a start from the truth reaches with the corners that the answer uses.
Optimum truth_with_corners_of(const RandomRig& rig, const CalibrationProblem& with_prior, const BundleState& answer) {
  BundleState state = rig.truth;
  state.fates = answer.fates;
  for (std::size_t v = 0; v < state.pose_of_view.size(); ++v) {
    if (answer.pose_of_view[v] < 0) state.pose_of_view[v] = -1;
  }
  return optimum_from_truth(with_prior, state, bent(answer.shapes[0]));
}

/// Squared distances [sigmas] of all corners, each cut off at the limit of outliers.
double squares_cut_off(const RandomRig& rig, const BundleState& state) {
  constexpr double kLimit = 5.0;
  double sum = 0.0;
  for (std::size_t v = 0; v < rig.problem.views.size(); ++v) {
    const std::vector<Eigen::Vector2d> residuals = view_residuals(rig.problem, state, static_cast<int>(v));
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const double distance = residuals[i].norm() / rig.problem.views[v].observations[i].sigma_px;
      sum += std::pow(distance < kLimit ? distance : kLimit, 2);  // also where nothing projects
    }
  }
  return sum;
}

/// Whether the corners themselves speak for an answer that leaves right ones out: among few, wrong ones may agree with
/// some right ones better than the right ones agree with each other. As many must be in use as are right.
bool corners_prefer(const RandomRig& rig, const TruthStart& truth, const BundleState& answer) {
  const auto used = [](const BundleState& state) {
    std::ptrdiff_t count = 0;
    for (const auto& fates : state.fates) count += std::ranges::count(fates, ObservationFate::kUsed);
    return count;
  };
  return used(answer) >= used(rig.truth) && squares_cut_off(rig, answer) <= squares_cut_off(rig, truth.optimum);
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

TruthStart start_from_truth(const RandomRig& rig) {
  const Optimum optimum = optimum_from_truth(with_lens_prior(rig, rig.truth), rig.truth);
  TruthStart start{.optimum = optimum.state, .cost = optimum.summary.final_cost};
  start.projection_sigma_px = std::numeric_limits<double>::infinity();
  ReducedInformation information = reduced_information(optimum.problem, optimum.state);
  information.chi2 = std::max(0, information.residuals - information.parameters);  // the noise is known
  const CovarianceResult known = covariance(information);
  if (known.unseen) return start;
  const Camera& camera = start.optimum.cameras[0];
  start.projection_sigma_px = testing::projection_sigma_px(
      camera, covariance_of_intrinsics(known.covariance, rig.problem.cameras[0].name, camera.model), right_rays(rig));
  // Fewer than three views are refused whatever they tell: nothing would be left to hold an answer against.
  int views = 0;
  for (std::size_t v = 0; v < rig.problem.views.size(); ++v) views += may_have_pose(rig, v);
  if (views < 3) return start;
  start.determined = start.projection_sigma_px < kUndeterminedShare * std::max(camera.size.width, camera.size.height);
  return start;
}

bool another_lens_fits(const RandomRig& rig, const TruthStart& truth) {
  const CalibrationProblem problem = with_lens_prior(rig, rig.truth);
  const Camera& here = truth.optimum.cameras[0];
  const std::vector<Eigen::Vector3d> rays = right_rays(rig);
  const auto as_good_elsewhere = [&](const BundleState& other, const BundleSummary& summary) {
    if (summary.termination == Termination::kFailed) return false;
    const double cost = cost_of(problem, other);  // with the priors of what was held
    const double sigmas = std::sqrt(std::max(0.0, 2.0 * (cost - truth.cost)));
    if (!(sigmas <= 3.0)) return false;
    const double apart_px = projection_difference_px(here, other.cameras[0], rays);
    return apart_px / std::max(1.0, sigmas) >= kUndeterminedShare * std::max(here.size.width, here.size.height);
  };
  // Everything else settles around what is held of the lens; then that goes, too.
  const auto leads_elsewhere = [&](BundleState other, const std::vector<std::string>& held_names) {
    CalibrationProblem held = problem;
    held.cameras[0].parameters = other.cameras[0].parameters;
    for (const std::string& name : held_names) {
      held.rules.push_back({held.cameras[0].name + "." + name, ParameterRule::Kind::kFixed, {}, 0.0});
    }
    const BundleSummary around = solve_to_the_end(held, other);
    if (as_good_elsewhere(other, around)) return true;
    const BundleSummary from_there = solve_to_the_end(problem, other);
    return as_good_elsewhere(other, from_there);
  };
  if (leads_elsewhere(rig.truth, {"*"})) return true;
  for (const double times : {0.25, 0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.25, 1.4, 1.6, 2.0, 3.0, 4.0}) {
    BundleState other = truth.optimum;
    other.cameras[0].parameters.head<2>() *= times;
    for (BoardPose& pose : other.poses) pose.rig_from_target.translation *= times;
    if (leads_elsewhere(std::move(other), {"fx", "fy"})) return true;
  }
  return false;
}

double projection_error_px(const RandomRig& rig, const Camera& camera) {
  return projection_difference_px(rig.truth.cameras[0], camera, right_rays(rig));
}

double cost_of(const CalibrationProblem& problem, BundleState state) {
  BundleOptions options;
  options.max_iterations = 0;
  const BundleSummary summary = solve_bundle(problem, state, options);
  return summary.termination == Termination::kFailed ? std::numeric_limits<double>::infinity() : summary.final_cost;
}

Judgement judge_start(const RandomRig& rig, const TruthStart& truth) {
  Judgement judgement;
  CalibrateOptions options;
  options.threads = 1;
  const double begin = processor_seconds();
  try {
    const CalibrationResult result = calibrate(rig.problem, options);
    judgement.seconds = processor_seconds() - begin;
    const BundleState answer = state_of(result);
    const CalibrationProblem with_prior = with_priors_of(rig, answer, result.lens_priors);
    const double cost = cost_of(with_prior, answer);
    const Optimum truths = truth_with_corners_of(rig, with_prior, answer);
    const double from_truth = truths.summary.final_cost;
    const double kept = right_kept(rig, answer);
    judgement.error_sigmas = projection_error_px(rig, answer.cameras[0]) / truth.projection_sigma_px;
    const bool proper = !ends_among_corners(rig.problem, answer, 0) || ends_among_corners(rig.problem, truths.state, 0);
    const bool right_corners = kept >= kFewestRightKept || corners_prefer(rig, truth, answer);
    const bool reached = cost <= from_truth * (1.0 + kSameCost) + 1e-9 && right_corners && proper;
    if (!reached) judgement.verdict = truth.determined ? Verdict::kElsewhere : Verdict::kUndeterminedAnswer;
    judgement.why = fmt::format(
        "cost {:.8g}, from the truth {:.8g}, {:.1f} % of the right corners used, off the truth by {:.1f} sigma{}", cost,
        from_truth, 100 * kept, judgement.error_sigmas, bent(answer.shapes[0]) ? ", board bent" : "");
  } catch (const Error& error) {
    judgement.seconds = processor_seconds() - begin;
    const bool right =
        error.kind() == ErrorKind::kNotEnoughData && (!truth.determined || another_lens_fits(rig, truth));
    judgement.verdict = right ? Verdict::kRefusedRightly : Verdict::kRefusedWrongly;
    judgement.why = error.what();
  }
  return judgement;
}

bool reaches(const RandomRig& rig, const TruthStart& truth, const std::optional<BundleState>& answer) {
  if (!answer) return false;
  BundleState state = *answer;
  mark_projectable(rig.problem, state);
  if (state.fates != rig.truth.fates) return false;  // corners that the answer cannot even project
  const BundleSummary summary = solve_to_the_end(with_lens_prior(rig, truth.optimum), state);
  return summary.termination != Termination::kFailed && summary.final_cost <= truth.cost * (1.0 + kSameCost) + 1e-9;
}

}  // namespace raybundle::testing
