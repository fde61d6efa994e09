// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "robust_solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "raybundle/bundle/parameters.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/initialize/camera_start.hpp"

namespace raybundle {
namespace {

constexpr double kSmallestDistance_px = 1e-3;  // exact data: rounding is not to be mistaken for outliers
constexpr int kMaxRounds = 8;
constexpr int kRobustIterations = 8;       // of a round: enough to tell outliers; least squares does the rest
constexpr double kRobustSettled = 1e-4;    // the same
constexpr double kKeepsWeight = 2.0;       // scale over the distance of a corner that is to keep most of its weight
constexpr double kNarrowed = 0.25;         // the scale of right corners that are far off, from round to round
constexpr int kFarOffIterations = 20;      // of such a round: the way is longer
constexpr std::size_t kFewestCorners = 4;  // of a view: fewer do not determine a pose

// Distances of measured corners from their projections, in sigmas; infinite where nothing projects.
std::vector<double> whitened_distances(const TargetView& view, const std::vector<Eigen::Vector2d>& residuals) {
  std::vector<double> distances;
  distances.reserve(residuals.size());
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const double distance = residuals[i].norm() / view.observations[i].sigma_px;
    distances.push_back(std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity());
  }
  return distances;
}

// The same of every view.
using Distances = std::vector<std::vector<double>>;
Distances whitened_distances(const CalibrationProblem& problem, const BundleState& state) {
  Distances distances;
  for (const std::vector<Eigen::Vector2d>& residuals : all_residuals(problem, state)) {
    distances.push_back(whitened_distances(problem.views[distances.size()], residuals));
  }
  return distances;
}

// Pose of the view's board in its frame as other views in use see it, of several the one that the view fits best; -1
// when there is none.
int shared_pose(const CalibrationProblem& problem, BundleState state, int view) {
  int best = -1;
  double best_distance = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const bool same_board =
        problem.views[v].frame == problem.views[view].frame && problem.views[v].target == problem.views[view].target;
    const int pose = static_cast<int>(v) == view ? -1 : state.pose_of_view[v];
    if (!same_board || pose < 0) continue;
    state.pose_of_view[view] = pose;
    std::vector<double> distances = whitened_distances(problem.views[view], view_residuals(problem, state, view));
    const double distance = median(distances);
    if (best >= 0 && !(distance < best_distance)) continue;
    best = pose;
    best_distance = distance;
  }
  return best;
}

// Pose of a view under its camera. First with the noise that the camera has: among few corners, wrong ones that are a
// pixel off can agree on a wrong pose. Then with the usual tolerance.
std::optional<Rigid3> pose_again(const CalibrationProblem& problem, const TargetView& view, const Camera& camera,
                                 double limit_px, std::string& reason) {
  constexpr double kUsual_px = 3.0;
  if (limit_px < kUsual_px) {
    if (auto pose = initialize_view(problem, view, camera, reason, limit_px)) return pose;
  }
  return initialize_view(problem, view, camera, reason, kUsual_px);
}

// Whether the board's points that a view's corners in use show lie on one line, about which the board may turn freely.
bool on_one_line(const CalibrationProblem& problem, const TargetView& view, const std::vector<ObservationFate>& fates) {
  const Target& target = problem.targets[view.target];
  std::optional<Eigen::Vector3d> first, along;
  for (std::size_t i = 0; i < fates.size(); ++i) {
    if (fates[i] != ObservationFate::kUsed) continue;
    const Eigen::Vector3d& x_in_target = target.find(view.observations[i].point_id)->x_in_target;
    if (!first) {
      first = x_in_target;
      continue;
    }
    const Eigen::Vector3d offset = x_in_target - *first;
    if (!along) along = offset;
    if (along->cross(offset).norm() > 1e-6 * along->norm() * offset.norm()) return false;
  }
  return true;
}

// Why a view whose corners are marked cannot stay; empty when it can.
//
// @param alone  no other view shares the pose
std::string why_aside(const CalibrationProblem& problem, const std::vector<double>& distances,
                      const std::vector<ObservationFate>& fates, int view, bool alone) {
  const auto used = static_cast<std::size_t>(std::ranges::count(fates, ObservationFate::kUsed));
  if (used < kFewestCorners || 2 * used < fates.size()) {
    std::vector<double> distances_px;
    for (std::size_t i = 0; i < distances.size(); ++i) {
      distances_px.push_back(distances[i] * problem.views[view].observations[i].sigma_px);
    }
    return fmt::format("only {} of {} corners fit the camera; the median distance is {:.2f} px", used, fates.size(),
                       median(distances_px));
  }
  if (!alone || !on_one_line(problem, problem.views[view], fates)) return {};
  return fmt::format("the {} of {} corners that fit the camera lie on one line", used, fates.size());
}

// Marks one view's corners by their distances; sets the view aside when most of them are outliers, or those that are
// not leave its board's pose open.
void mark_view(const CalibrationProblem& problem, const std::vector<double>& distances, BundleState& state, int view,
               double limit, bool alone, std::string& reason) {
  std::vector<ObservationFate>& fates = state.fates[view];
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const double sigma = problem.views[view].observations[i].sigma_px;
    const bool fits =
        std::isfinite(distances[i]) && (distances[i] <= limit || distances[i] * sigma <= kSmallestDistance_px);
    fates[i] = fits ? ObservationFate::kUsed
                    : (std::isinf(distances[i]) ? ObservationFate::kUnprojectable : ObservationFate::kOutlier);
  }
  std::string why = why_aside(problem, distances, fates, view, alone);
  if (why.empty()) return;
  reason = std::move(why);
  state.pose_of_view[view] = -1;
  std::ranges::fill(fates, ObservationFate::kViewSetAside);
}

// Standard deviation of the noise under distances from a fit that had so many unknowns. The fit swallows the noise of
// some corners and leaves that of others; where it swallows much, the median tells too little, and the corners that are
// not outliers tell it by their sum.
double fitted_sigma(std::vector<double> distances, double unknowns) {
  if (distances.empty()) return std::numeric_limits<double>::infinity();
  const auto degrees_of_freedom = [&](double corners) { return std::max(2.0 * corners - unknowns, 0.5 * corners); };
  const auto corners = static_cast<double>(distances.size());
  const double sigma = std::sqrt(2.0 * corners / degrees_of_freedom(corners)) * median(distances) / kRayleighMedian;
  constexpr double kMuchLeft = 1.6;    // of the two values of each corner: the fit has swallowed a fifth of them
  constexpr double kUsualLimit = 5.0;  // sigmas; as CalibrateOptions::outlier_sigma is unless asked otherwise
  if (!std::isfinite(sigma) || degrees_of_freedom(corners) > kMuchLeft * corners) return sigma;
  double sum = 0.0, right = 0.0;
  for (const double distance : distances) {
    if (!(distance <= kUsualLimit * sigma)) continue;
    sum += distance * distance;
    right += 1.0;
  }
  return std::max(sigma, std::sqrt(sum / std::max(degrees_of_freedom(right), 1.0)));
}

// How many views share each pose.
std::vector<int> views_of_poses(const BundleState& state) {
  std::vector<int> views(state.poses.size(), 0);
  for (const int pose : state.pose_of_view) {
    if (pose >= 0) ++views[pose];
  }
  return views;
}

// How many parameters of each camera's lens its corners may move.
std::vector<double> free_of_lenses(const CalibrationProblem& problem, const BundleState& state) {
  std::vector<double> free;
  for (const Camera& camera : state.cameras) free.push_back(static_cast<double>(camera.parameters.size()));
  if (problem.rules.empty()) return free;
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    if (block.kind != ParameterBlock::Kind::kIntrinsics) continue;
    free[static_cast<std::size_t>(block.owner)] = static_cast<double>(block.free().size());
  }
  return free;
}

// Standard deviation of the noise of each camera's corners.
std::vector<double> sigmas_of(const CalibrationProblem& problem, const BundleState& state, const Distances& distances) {
  const std::vector<int> views_of_pose = views_of_poses(state);
  std::vector<std::vector<double>> of_cameras(problem.cameras.size());
  std::vector<double> unknowns = free_of_lenses(problem, state);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    std::vector<double>& of_camera = of_cameras[problem.views[v].camera];
    of_camera.insert(of_camera.end(), distances[v].begin(), distances[v].end());
    unknowns[problem.views[v].camera] += 6.0 / views_of_pose[state.pose_of_view[v]];
  }
  std::vector<double> sigmas;
  for (std::size_t c = 0; c < of_cameras.size(); ++c) {
    sigmas.push_back(fitted_sigma(std::move(of_cameras[c]), unknowns[c]));
  }
  return sigmas;
}

// Sum of the squared distances, each cut off at the limit of outliers.
double squares_cut_off(const Distances& distances, double limit_sigmas) {
  double sum = 0.0;
  for (const std::vector<double>& of_view : distances) {
    for (const double distance : of_view) sum += std::pow(std::min(distance, limit_sigmas), 2);
  }
  return sum;
}

// Median of what the corners state.
double usual_sigma_px(const CalibrationProblem& problem) {
  std::vector<double> sigmas;
  for (const TargetView& view : problem.views) {
    for (const Observation& seen : view.observations) sigmas.push_back(seen.sigma_px);
  }
  return sigmas.empty() ? 1.0 : median(sigmas);
}

}  // namespace

BundleOptions bundle_options(const CalibrateOptions& options) {
  BundleOptions bundle;
  bundle.max_iterations = options.max_iterations;
  bundle.threads = options.threads;
  return bundle;
}

std::vector<double> robust_sigmas(const CalibrationProblem& problem, const BundleState& state) {
  return sigmas_of(problem, state, whitened_distances(problem, state));
}

double prior_squares(const CalibrationProblem& problem, const BundleState& state) {
  double sum = 0.0;
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    if (block.with_prior().empty()) continue;
    const PriorMean mean = prior_mean(problem, state, block);
    sum += prior_residual(block, mean, current_values(state, block)).residual.squaredNorm();
  }
  return sum;
}

bool is_better(const CalibrationProblem& single, const SolvedState& after, const SolvedState& before,
               const CalibrateOptions& options, std::optional<double> priors_before) {
  if (after.summary.termination == Termination::kFailed) return false;
  if (before.summary.termination == Termination::kFailed) return true;
  if (spoils_lens(single, before.state, after.state)) return false;
  const Distances here = whitened_distances(single, after.state), there = whitened_distances(single, before.state);
  const double sigma = std::min(sigmas_of(single, after.state, here)[0], sigmas_of(single, before.state, there)[0]);
  const double limit = outlier_limit(options, sigma);
  if (!priors_before) priors_before = prior_squares(single, before.state);
  return squares_cut_off(here, limit) + prior_squares(single, after.state) <
         squares_cut_off(there, limit) + *priors_before;
}

double outlier_limit(const CalibrateOptions& options, double sigma) {
  return options.outlier_sigma * std::max(sigma, kExactNoise);
}

double all_squares(const CalibrationProblem& problem, const BundleState& state, double limit_sigmas) {
  return squares_cut_off(whitened_distances(problem, state), limit_sigmas) + prior_squares(problem, state);
}

std::string outlier_rule(const CalibrateOptions& options) {
  return fmt::format(
      "corners farther from their projection than {:g} robust sigmas of their camera (median distance / 1.1774, in "
      "units of each corner's own sigma, times the root of values per degree of freedom; where the fit has swallowed a "
      "fifth of the values, the root of their sum of squares per degree of freedom where that is larger) are left out; a view with "
      "more than half of its corners left out, fewer than {} in use, or all of these on one line of the board, is set "
      "aside",
      options.outlier_sigma, kFewestCorners);
}

bool mark_outliers(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                   std::vector<std::string>& reasons) {
  const Distances distances = whitened_distances(problem, state);
  const std::vector<double> sigmas = sigmas_of(problem, state, distances);
  const std::vector<std::vector<ObservationFate>> before = state.fates;
  const std::vector<int> views_of_pose = views_of_poses(state);
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    const double limit = options.outlier_sigma * sigmas[problem.views[v].camera];
    const bool alone = views_of_pose[state.pose_of_view[v]] == 1;
    mark_view(problem, distances[v], state, v, limit, alone, reasons[v]);
  }
  return state.fates != before;
}

BundleSummary solve_robustly(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                             double off_px) {
  BundleOptions bundle = bundle_options(options);
  bundle.settled = kRobustSettled;
  BundleSummary summary;
  const double widest =
      off_px > 0.0 ? kKeepsWeight * off_px / usual_sigma_px(problem) / options.robust_scale_sigma : 0.0;
  double previous = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kMaxRounds; ++round) {
    double sigma = 0.0;
    for (double of_camera : robust_sigmas(problem, state)) {
      if (std::isfinite(of_camera)) sigma = std::max(sigma, of_camera);
    }
    const double far_off = widest * std::pow(kNarrowed, round);
    bundle.max_iterations = std::min(options.max_iterations, far_off > sigma ? kFarOffIterations : kRobustIterations);
    sigma = std::max(sigma, far_off);
    const bool under_way = summary.termination == Termination::kIterationLimit;
    if (!(sigma < (under_way ? 0.98 : 0.9) * previous)) break;  // the scale has settled
    previous = sigma;
    bundle.robust_scale_sigma = options.robust_scale_sigma * std::max(sigma, kSmallestDistance_px);
    summary = solve_bundle(problem, state, bundle);
    if (summary.termination == Termination::kFailed) break;
    mark_projectable(problem, state);
  }
  return summary;
}

bool give_second_chance(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                        std::vector<std::string>& reasons) {
  bool taken = false;
  if (std::ranges::none_of(state.pose_of_view, [](int pose) { return pose < 0; })) return taken;
  const std::vector<double> sigmas = robust_sigmas(problem, state);
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const TargetView& view = problem.views[v];
    if (state.pose_of_view[v] >= 0 || view.observations.size() < kFewestCorners) continue;
    const Rigid3& camera_from_rig = state.camera_from_rig[view.camera];
    std::string reason;
    const double limit_px =
        std::max(options.outlier_sigma * sigmas[view.camera] * view.observations[0].sigma_px, kSmallestDistance_px);
    const std::optional<Rigid3> own = pose_again(problem, view, state.cameras[view.camera], limit_px, reason);
    if (!own) {
      reasons[v] = reason;
      continue;
    }
    taken = true;
    // A board that the other cameras saw in the frame stays one board; whether the view fits it is for the outlier
    // rule.
    state.pose_of_view[v] = shared_pose(problem, state, v);
    if (state.pose_of_view[v] < 0) {
      state.pose_of_view[v] = static_cast<int>(state.poses.size());
      state.poses.push_back({view.frame, view.target, camera_from_rig.inverse() * *own});
    }
  }
  if (taken) mark_projectable(problem, state);
  return taken;
}

BundleSummary solve_without_outliers(const CalibrationProblem& problem, BundleState& state,
                                     const CalibrateOptions& options, bool estimate_shape,
                                     std::vector<std::string>& reasons, const BundleSummary& solved) {
  BundleOptions bundle = bundle_options(options);
  bundle.estimate_shape = estimate_shape;
  BundleSummary summary = solved;
  for (int round = 0; round < kMaxRounds; ++round) {
    const bool changed = mark_outliers(problem, state, options, reasons);
    const bool at_rest = summary.termination == Termination::kConverged || summary.termination == Termination::kBlocked;
    if (!changed && at_rest) break;
    if (!changed && round > 0) break;
    summary = solve_bundle(problem, state, bundle);
    if (summary.termination == Termination::kFailed) break;
  }
  return summary;
}

}  // namespace raybundle
