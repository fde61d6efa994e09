// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "joint_solve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "board_sizes.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/geometry/error.hpp"
#include "subproblem.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kMaxTieReviews = 10;
// Of the frames that could tie the cameras, kept in any case.
constexpr std::array kSharesKept{0.75, 0.5, 0.25};
constexpr std::array kFewKept{0.75, 0.5, 0.25, 0.1};
// BundleOptions::settled of solves by which only ties are decided and others begin: what is left of the cost moves a
// frame's excess by less than a thousandth of what frames of the same moment differ by.
constexpr double kTieSettled = 1e-10;
constexpr double kBentByTies = 2.0;  // times the noise of a camera alone: what its own corners would not bear

// Solves with the ties as they are reviewed, each time with a smaller share that is kept in any case: the worst frames
// go first.
//
// @param settled  as BundleOptions
BundleSummary solve_and_review_ties(const CalibrationProblem& problem, BundleState& state,
                                    std::span<const double> shares_kept, const CalibrateOptions& options, Ties& ties,
                                    double settled = kTieSettled) {
  BundleOptions bundle = bundle_options(options);
  bundle.settled = settled;
  BundleSummary summary;
  for (std::size_t round = 0; round < kMaxTieReviews; ++round) {
    ties.rule.share_kept = shares_kept[std::min(round, shares_kept.size() - 1)];
    ties.review = review_ties(problem, state, options, ties.rule, settled);
    const bool last = ties.review.strict || ties.rule.share_kept == shares_kept.back();
    if (!ties.review.changed && last) break;
    summary = solve_bundle(problem, state, bundle);
  }
  return summary;
}

bool places_free(const CalibrationProblem& problem) {
  return std::ranges::any_of(parameter_blocks(problem), [](const ParameterBlock& block) {
    return block.kind == ParameterBlock::Kind::kCameraFromRig &&
           std::ranges::any_of(block.parameters,
                               [](const Parameter& p) { return p.kind != ParameterRule::Kind::kFixed; });
  });
}

// Boards that move between exposures are off by pixels. By more than half a percent of the image's diagonal, even in
// the frames that agree best, they are not the same moment at all. Of cameras that are held where they are, one may
// have moved: that is for whoever holds them to say.
void refuse_unrelated_images(const CalibrationProblem& problem, const TieReview& ties) {
  if (!places_free(problem)) return;
  double diagonal_px = std::numeric_limits<double>::infinity();
  for (const ProblemCamera& camera : problem.cameras) {
    diagonal_px = std::min(diagonal_px, std::hypot(camera.size.width, camera.size.height));
  }
  if (ties.typical_px <= 0.005 * diagonal_px) return;
  throw Error(ErrorKind::kNotEnoughData,
              "the cameras saw the board in different places, even in the frames that agree best typically " +
                  std::to_string(std::lround(ties.typical_px)) +
                  " px apart, though each fits by itself; do the images that have the same number belong to the same "
                  "moment? Check the numbers, or calibrate the cameras one by one");
}

// Whether a camera fits plainly worse than by itself: wrong ties have bent its lens.
bool lenses_bent(const CalibrationProblem& problem, const BundleState& state, const std::vector<double>& sigmas_alone) {
  const std::vector<double> sigmas = robust_sigmas(problem, state);
  for (std::size_t c = 0; c < sigmas.size(); ++c) {
    if (sigmas[c] > kBentByTies * std::max(sigmas_alone[c], kExactNoise)) return true;
  }
  return false;
}

// The rig from the frames that tie its cameras. Where images of different moments have come together, wrong ties bend
// the lenses: then first from the few that agree best, under lenses that stay what each camera alone tells. Ties of
// cameras that do not expose together are worth less than the corners: then the lenses stay so to the end.
BundleSummary solve_rig(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                        const std::vector<double>& sigmas_alone, Ties& ties) {
  refuse_boards_of_other_sizes(problem, state);
  const CalibrationProblem rig_only = with_fixed_intrinsics(problem, state);
  solve_robustly(rig_only, state, options);
  const BundleState with_lenses_alone = state;
  const auto plainly_tied = [&] { return !ties.review.doubtful && !lenses_bent(problem, state, sigmas_alone); };
  BundleSummary summary = solve_and_review_ties(problem, state, kSharesKept, options, ties);
  if (plainly_tied()) return summary;
  ties.rule.wary = true;
  state = with_lenses_alone;
  solve_and_review_ties(rig_only, state, kFewKept, options, ties);
  const BundleState from_few = state;
  solve_bundle(problem, state, bundle_options(options));
  summary = solve_and_review_ties(problem, state, std::span(kFewKept).last(1), options, ties);
  if (plainly_tied()) return summary;
  ties.rule.unsynchronised = true;
  state = from_few;
  summary = solve_and_review_ties(rig_only, state, kFewKept, options, ties, BundleOptions().settled);
  refuse_unrelated_images(problem, ties.review);
  return summary;
}

// Every camera whose place nobody has given must share a board's pose with one whose place is known.
void refuse_unlinked(const CalibrationProblem& problem, const BundleState& state) {
  std::vector<bool> linked(problem.cameras.size());
  for (std::size_t c = 0; c < linked.size(); ++c) linked[c] = c == 0 || problem.cameras[c].camera_from_rig;
  std::vector<bool> pose_known(state.poses.size(), false);
  for (std::size_t round = 0; round < linked.size(); ++round) {
    for (std::size_t v = 0; v < problem.views.size(); ++v) {
      if (state.pose_of_view[v] >= 0 && linked[problem.views[v].camera]) pose_known[state.pose_of_view[v]] = true;
    }
    for (std::size_t v = 0; v < problem.views.size(); ++v) {
      if (state.pose_of_view[v] >= 0 && pose_known[state.pose_of_view[v]]) linked[problem.views[v].camera] = true;
    }
  }
  const auto lost = std::ranges::find(linked, false);
  if (lost == linked.end()) return;
  throw Error(ErrorKind::kNotEnoughData,
              "in no frame did " + problem.cameras[lost - linked.begin()].name +
                  " see the board where another camera saw it; do the images that have the same number belong to the "
                  "same moment? Check the numbers, or calibrate the cameras one by one");
}

// Sum of squared whitened residuals of the corners that both states use.
double chi2_in_common(const CalibrationProblem& problem, const BundleState& state, const BundleState& other,
                      double& corners) {
  double chi2 = corners = 0.0;
  const std::vector<std::vector<Eigen::Vector2d>> of_views = all_residuals(problem, state);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (state.pose_of_view[v] < 0 || other.pose_of_view[v] < 0) continue;
    const std::vector<Eigen::Vector2d>& residuals = of_views[v];
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

constexpr double kSmallestGain = 0.02;    // in the sum of squares, of a bent board
constexpr std::size_t kTellShape = 6000;  // corners: so many tell whether a bend may pay

// Whether bending the boards could lower the squared residuals enough, by some of them. A lens that has taken a bend upon
// itself leaves the flat optimum along a valley: the first steps are often refused, and say nothing.
bool shape_may_pay(const CalibrationProblem& problem, const BundleState& flat, const CalibrateOptions& options) {
  BundleState bent = with_fewer_views(flat, kTellShape);
  BundleOptions bundle = bundle_options(options);
  bundle.max_iterations = 20;
  bundle.settled = 1e-6;
  bundle.estimate_shape = true;
  const BundleSummary summary = solve_bundle(problem, bent, bundle);
  if (summary.termination != Termination::kConverged && summary.final_cost == summary.initial_cost) return true;
  return summary.initial_cost - summary.final_cost > 0.25 * kSmallestGain * summary.initial_cost;
}

// A bent board must lower the squared residuals by 2 % (the rms by 1 %) and, as an F-test, by 20 per parameter: far
// beyond chance (99.9 % of F(3, n) lies below 5.5) because corner errors are not independent.
bool data_carry_shape(const CalibrationProblem& problem, const BundleState& flat, const BundleState& bent) {
  double corners = 0.0;
  const double chi2_flat = chi2_in_common(problem, flat, bent, corners);
  const double chi2_bent = chi2_in_common(problem, bent, flat, corners);
  const double gain = chi2_flat - chi2_bent;
  const double parameters = 3.0 * static_cast<double>(problem.targets.size());
  return gain > kSmallestGain * chi2_flat && gain / parameters > 20.0 * chi2_bent / (2.0 * corners);
}

// Whether a rule gives a board a shape, which then does not depend on what the data carry.
bool shape_is_given(const CalibrationProblem& problem) {
  return std::ranges::any_of(parameter_blocks(problem), [](const ParameterBlock& block) {
    return block.kind == ParameterBlock::Kind::kShape &&
           std::ranges::any_of(block.parameters, [](const Parameter& p) { return p.value.has_value(); });
  });
}

// Bends the boards where that is asked for and the data carry it, or a rule gives their shape; whether it did.
bool bend_boards(const CalibrationProblem& problem, const CalibrateOptions& options, SolvedState& flat) {
  const bool flat_board = std::ranges::any_of(problem.targets, &Target::flat);
  if (!options.estimate_shape || !flat_board || flat.summary.termination == Termination::kFailed) return false;
  const bool given = shape_is_given(problem);
  if (!given && !shape_may_pay(problem, flat.state, options)) return false;
  SolvedState bent = flat;
  bent.summary = solve_without_outliers(problem, bent.state, options, true, bent.reasons);
  if (bent.summary.termination == Termination::kFailed) return false;
  if (!given && !data_carry_shape(problem, flat.state, bent.state)) return false;
  flat = std::move(bent);
  return true;
}

// Boards are flat again, but for shapes that a rule fixes; whether that changed any.
bool forget_shapes(const CalibrationProblem& problem, BundleState& state) {
  const std::vector<BoardShape> before = std::exchange(state.shapes, std::vector<BoardShape>(problem.targets.size()));
  apply_fixed_values(problem, parameter_blocks(problem), state);
  return state.shapes != before;
}

}  // namespace

JointSolve solve_jointly(const CalibrationProblem& problem, const CalibrateOptions& options,
                         const std::vector<double>& sigmas_alone, SolvedState start) {
  JointSolve solve{std::move(start), {}, false};
  auto& [state, reasons, summary] = solve.solved;
  const bool reshaped = forget_shapes(problem, state);
  if (problem.cameras.size() > 1) summary = solve_rig(problem, state, options, sigmas_alone, solve.ties);
  if (!solve.ties.rule.unsynchronised) {
    const bool changed = give_second_chance(problem, state, options, reasons);
    const bool still_solved = problem.cameras.size() == 1 && !changed && !reshaped;
    const BundleSummary so_far = still_solved ? summary : BundleSummary{};
    summary = solve_without_outliers(problem, state, options, false, reasons, so_far);
    solve.shape_estimated = bend_boards(problem, options, solve.solved);
    // As long as it was taken for flat, a bent board may have seemed to move.
    if (solve.shape_estimated) solve.ties.review = review_ties(problem, state, options, solve.ties.rule);
    if (solve.shape_estimated && solve.ties.review.changed) {
      summary = solve_without_outliers(problem, state, options, true, reasons);
    }
  }
  if (summary.termination == Termination::kFailed) {
    throw Error(ErrorKind::kSolveFailed, "the bundle adjustment broke down: " + summary.message);
  }
  refuse_unlinked(problem, state);
  return solve;
}

}  // namespace raybundle
