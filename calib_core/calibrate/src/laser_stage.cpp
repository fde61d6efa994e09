// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_stage.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "beam_ranges.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/initialize/beam_start.hpp"
#include "raybundle/uncertainty/beam_ambiguity.hpp"
#include "raybundle/uncertainty/beam_depth.hpp"
#include "subproblem.hpp"

namespace raybundle {
namespace {

constexpr int kMaxRounds = 8;
constexpr int kFewestHits = 2;          // of a beam without a model to lean on
constexpr int kHitsOfStrong = 3;        // of a beam that needs no prior ...
constexpr double kStrongDepth_m = 0.1;  // ... and how far apart along it they lie
constexpr double kLooseness = 3.0;      // a prior's sigma over the farthest of the strong beams
constexpr int kFewestStrong = 8;        // beams that tell how well the common model holds

LaserScene scene_of(const CalibrationProblem& problem, const BundleState& state) {
  LaserScene scene{problem, state.cameras, state.camera_from_rig, {}, state.shapes};
  for (const int pose : state.pose_of_view) {
    scene.rig_from_target.push_back(pose < 0 ? std::nullopt : std::optional(state.poses[pose].rig_from_target));
  }
  return scene;
}

/// Distances of a view's dots from their predictions, in stated sigmas; infinite where there is no prediction.
std::vector<double> whitened_distances(const CalibrationProblem& problem, const BundleState& state, int view) {
  const std::vector<Eigen::Vector2d> residuals = dot_residuals(problem, state, view);
  std::vector<double> distances;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const Eigen::Matrix2d& covariance = problem.views[view].dots[i].covariance_px2;
    const double squared = residuals[i].dot(covariance.inverse() * residuals[i]);
    distances.push_back(std::isfinite(squared) ? std::sqrt(squared) : std::numeric_limits<double>::infinity());
  }
  return distances;
}

bool takes_part(ObservationFate fate) { return fate == ObservationFate::kUsed || fate == ObservationFate::kOutlier; }

/// Robust size of the dots' errors over what their sigmas say, by the beams with more dots than determine a line. Their
/// residuals are smaller than the errors, by the four unknowns that each beam takes from its dots.
double robust_scale(const CalibrationProblem& problem, const BundleState& state) {
  constexpr std::size_t kFewestDots = 3;  // of a beam
  constexpr std::size_t kFewest = 20;     // of all: fewer tell less than what is stated
  std::map<int, std::vector<double>> distances_of_beam;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const std::vector<double> of_view = whitened_distances(problem, state, v);
    for (std::size_t i = 0; i < of_view.size(); ++i) {
      const bool counts = takes_part(state.dot_fates[v][i]) && std::isfinite(of_view[i]);
      if (counts) distances_of_beam[problem.views[v].dots[i].beam].push_back(of_view[i]);
    }
  }
  std::vector<double> distances;
  double unknowns = 0.0;
  for (const auto& [beam, of_beam] : distances_of_beam) {
    if (of_beam.size() < kFewestDots) continue;
    distances.insert(distances.end(), of_beam.begin(), of_beam.end());
    unknowns += 4.0;
  }
  if (distances.size() < kFewest) return 1.0;
  const double equations = 2.0 * static_cast<double>(distances.size());
  return median(distances) / kRayleighMedian * std::sqrt(equations / (equations - unknowns));
}

void scale_dots(CalibrationProblem& problem, double scale) {
  for (TargetView& view : problem.views) {
    for (Dot& dot : view.dots) {
      const double least = kSmallestSigma_px * kSmallestSigma_px / dot.covariance_px2.diagonal().minCoeff();
      dot.covariance_px2 *= std::max(scale * scale, least);
    }
  }
}

/// Scales the dots' sigmas to what their residuals show.
///
/// @return  the factor that the residuals ask for
double rescale_dots(LaserSolve& solve) {
  const double scale = robust_scale(solve.problem, solve.state);
  solve.laser.sigma_scale *= scale;
  scale_dots(solve.problem, scale);
  return scale;
}

void label_dots(const std::vector<std::vector<int>>& beam_of_dot, CalibrationProblem& problem) {
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    for (std::size_t i = 0; i < problem.views[v].dots.size(); ++i) problem.views[v].dots[i].beam = beam_of_dot[v][i];
  }
}

/// True when a dot has changed sides.
bool mark_outliers(const CalibrationProblem& problem, double limit, BundleState& state) {
  const std::vector<std::vector<ObservationFate>> before = state.dot_fates;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const std::vector<double> distances = whitened_distances(problem, state, v);
    for (std::size_t i = 0; i < distances.size(); ++i) {
      ObservationFate& fate = state.dot_fates[v][i];
      if (takes_part(fate)) fate = distances[i] <= limit ? ObservationFate::kUsed : ObservationFate::kOutlier;
    }
  }
  return state.dot_fates != before;
}

/// Line of a beam by the common model, its point as near as it comes to the place given.
std::optional<Line3> line_of_model_near(const LaserPattern& pattern, int beam, const Eigen::Vector3d& near) {
  std::optional<Line3> line = line_of_model(pattern, pattern.grid.row(beam), pattern.grid.column(beam));
  if (line) line->point += line->direction.dot(near - line->point) * line->direction;
  return line;
}

/// A prior for weak beams, none for those that need none. A model of the grating and its lens is worst where the weak
/// beams are, at the rim: so they may be as far from it as the farthest of the others.
std::vector<std::optional<BeamPrior>> priors_of(const LaserPattern& pattern, const std::vector<BeamRanges>& hits,
                                                const BundleState& state) {
  double offset_m = 1e-9, slope_rad = 1e-9;
  int strong_beams = 0;
  std::vector<int> weak;
  for (int b = 0; b < pattern.grid.size(); ++b) {
    if (!state.beams[b]) continue;
    const bool strong = hits[b].count() >= kHitsOfStrong && hits[b].depth_m() >= kStrongDepth_m;
    if (!strong) weak.push_back(b);
    const std::optional<Line3> model = line_of_model_near(pattern, b, state.beams[b]->point);
    if (!strong || !model) continue;
    const Eigen::Vector4d motion = motion_between(*model, *state.beams[b]);
    offset_m = std::max(offset_m, motion.head<2>().norm());
    slope_rad = std::max(slope_rad, motion.tail<2>().norm());
    ++strong_beams;
  }
  std::vector<std::optional<BeamPrior>> priors(weak.empty() ? 0 : state.beams.size());
  if (strong_beams < kFewestStrong) return priors;
  const Eigen::Vector4d sigma = kLooseness * Eigen::Vector4d(offset_m, offset_m, slope_rad, slope_rad);
  for (const int b : weak) {
    const std::optional<Line3> model = line_of_model_near(pattern, b, state.beams[b]->point);
    if (model) priors[b] = BeamPrior{*model, sigma.cwiseAbs2().cwiseInverse().asDiagonal()};
  }
  return priors;
}

/// Beams that too few dots determine, and no prior supports, leave.
void drop_undetermined(const std::vector<BeamRanges>& hits, const std::vector<std::optional<BeamPrior>>& priors,
                       BundleState& state) {
  for (std::size_t b = 0; b < state.beams.size(); ++b) {
    if (!state.beams[b] || (!priors.empty() && priors[b])) continue;
    const bool determined = hits[b].count() >= kFewestHits && hits[b].depth_m() > 0.1 * kStrongDepth_m;
    if (!determined) state.beams[b].reset();
  }
}

/// First with a robust loss, then least squares while dots come and go.
BundleSummary solve_all(const CalibrateOptions& options, LaserSolve& solve) {
  BundleOptions robust = solve.bundle;
  robust.robust_scale_sigma = options.robust_scale_sigma;
  BundleSummary summary = solve_bundle(solve.problem, solve.state, robust);
  for (int round = 0; round < kMaxRounds && summary.termination != Termination::kFailed; ++round) {
    const double scale = rescale_dots(solve);
    const bool changed = mark_outliers(solve.problem, options.outlier_sigma, solve.state);
    if (!changed && round > 0 && std::abs(scale - 1.0) < 0.02) break;
    summary = solve_bundle(solve.problem, solve.state, solve.bundle);
  }
  return summary;
}

void count_dots(LaserSolve& solve) {
  double squares = 0.0;
  for (int v = 0; v < static_cast<int>(solve.problem.views.size()); ++v) {
    const std::vector<Eigen::Vector2d> residuals = dot_residuals(solve.problem, solve.state, v);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const ObservationFate fate = solve.state.dot_fates[v][i];
      solve.laser.dots_used += fate == ObservationFate::kUsed;
      solve.laser.dots_outlier += fate == ObservationFate::kOutlier;
      solve.laser.dots_unlabelled += fate == ObservationFate::kUnlabelled;
      solve.laser.dots_unused += fate == ObservationFate::kViewSetAside || fate == ObservationFate::kUnprojectable;
      if (fate == ObservationFate::kUsed) squares += residuals[i].squaredNorm();
    }
  }
  if (solve.laser.dots_used > 0) solve.laser.rms_px = std::sqrt(squares / solve.laser.dots_used);
}

/// Four sigmas of a dot, as its residuals have shown them, lose one in thousands.
double label_tolerance_px(const LaserSolve& solve) {
  std::vector<double> sigmas;
  for (std::size_t v = 0; v < solve.problem.views.size(); ++v) {
    for (std::size_t i = 0; i < solve.problem.views[v].dots.size(); ++i) {
      if (solve.state.dot_fates[v][i] != ObservationFate::kUsed) continue;
      sigmas.push_back(std::sqrt(0.5 * solve.problem.views[v].dots[i].covariance_px2.trace()));
    }
  }
  constexpr double kLeast_px = 0.05;  // exact data: rounding is not to decide
  return std::max(4.0 * median(sigmas), kLeast_px);
}

}  // namespace

bool has_dots(const CalibrationProblem& problem) {
  return problem.laser && std::ranges::any_of(problem.views, [](const TargetView& view) { return !view.dots.empty(); });
}

LaserSolve solve_with_dots(const CalibrationProblem& problem, const BundleState& cameras, double corner_scale,
                           const CalibrateOptions& options, const BundleOptions& bundle) {
  LaserSolve solve{problem, cameras, bundle, {}, {}, {}, {}};
  const BeamStart start = initialize_beams(scene_of(problem, cameras));
  scale_corners(solve.problem, corner_scale);
  weigh_lens_priors(solve.problem, solve.state);
  label_dots(start.beam_of_dot, solve.problem);
  solve.state.beams = start.lines;
  solve.pattern = {.grid = problem.laser->grid,
                   .beams = {},
                   .grating = start.grating,
                   .zero_order_row = start.zero_order_row,
                   .zero_order_column = start.zero_order_column};
  solve.on_board = start.on_board;
  solve.laser.label_origin = start.origin;
  solve.laser.origin_guessed = start.origin_guessed;
  solve.laser.grating_rms_rad = start.grating_rms_rad;
  solve.bundle.threads = options.threads;
  solve.bundle.max_iterations = options.max_iterations;

  mark_dots(solve.problem, solve.state);
  std::vector<BeamRanges> hits = ranges_of_beams(solve.problem, solve.state);
  if (solve.pattern.grating) solve.bundle.beam_priors = priors_of(solve.pattern, hits, solve.state);
  drop_undetermined(hits, solve.bundle.beam_priors, solve.state);
  mark_dots(solve.problem, solve.state);
  rescale_dots(solve);
  solve.summary = solve_all(options, solve);
  if (solve.summary.termination == Termination::kFailed) {
    throw Error(ErrorKind::kSolveFailed, "the bundle adjustment with the laser's dots broke down: " +
                                             solve.summary.message + "; calibrate without [laser] to get the cameras");
  }

  hits = ranges_of_beams(solve.problem, solve.state);
  for (int b = 0; b < solve.pattern.grid.size(); ++b) {
    if (!solve.state.beams[b] || hits[b].count() == 0) continue;
    LaserBeam beam{solve.pattern.grid.row(b), solve.pattern.grid.column(b), *solve.state.beams[b]};
    beam.hits = hits[b].count();
    beam.nearest_hit_m = hits[b].nearest_m();
    beam.farthest_hit_m = hits[b].farthest_m();
    solve.pattern.beams.push_back(beam);
  }
  if (solve.pattern.beams.empty()) {
    throw Error(ErrorKind::kNotEnoughData,
                "no beam was met by the board at two distances; take more poses, near and far");
  }
  if (!solve.bundle.beam_priors.empty()) {
    solve.laser.beams_with_prior = static_cast<int>(std::ranges::count_if(solve.pattern.beams, [&](const LaserBeam& b) {
      return solve.bundle.beam_priors[solve.pattern.grid.index(b.row, b.column)].has_value();
    }));
  }
  count_dots(solve);
  return solve;
}

void fill_uncertainty(const LaserSolve& solve, const Covariance& parameters, double variance_factor,
                      const RigCamera& first_camera, LaserPattern& pattern) {
  const std::vector<std::optional<BeamCovariance>> known = beam_covariances(solve.problem, solve.state, solve.bundle);
  std::vector<LaserBeam> determined;
  for (LaserBeam& beam : pattern.beams) {
    const std::optional<BeamCovariance>& of_beam = known[pattern.grid.index(beam.row, beam.column)];
    if (!of_beam) continue;
    beam.covariance = variance_factor * of_beam->of_beam;
    const Eigen::MatrixXd with_parameters = variance_factor * of_beam->with_parameters;
    for (std::size_t d = 0; d < kStatedDepths_m.size(); ++d) {
      beam.depths[d] =
          beam_depth(first_camera, parameters, beam.line, beam.covariance, with_parameters, kStatedDepths_m[d]);
    }
    determined.push_back(beam);
  }
  pattern.beams = determined;
  const double tolerance_px = label_tolerance_px(solve);
  pattern.advice = LabelAdvice{beam_ambiguity(first_camera, pattern, tolerance_px), {}};
  if (pattern.grating) pattern.advice->best_turn = best_turn(first_camera, pattern, tolerance_px);
}

}  // namespace raybundle
