// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "corner_choice.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "lost_views.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/calibrate/lens_domain.hpp"

namespace raybundle {
namespace {

constexpr double kReadmitted = 4.0;           // times the limit of outliers
constexpr std::size_t kSwallowed = 4;         // corners for each unknown: of so few the fit swallows much of the noise
constexpr std::size_t kFewOfView = 8;         // corners: of so few a single one turns the board
constexpr int kFirstLook = 30;                // iterations
constexpr std::size_t kMostExchanged = 1000;  // corners: of more no single one holds the lens
constexpr std::size_t kMostPairs = 1000;      // that are tried
constexpr std::size_t kMostViews = 100;       // of more no single one moves the lens

std::size_t count_used(const std::vector<ObservationFate>& fates) {
  return static_cast<std::size_t>(std::ranges::count(fates, ObservationFate::kUsed));
}

/// A corner that was left out but may be right.
struct DoubtfulCorner {
  std::size_t view = 0, corner = 0;
  double distance = 0.0;  // from its projection [sigmas]
};

// Those of a view that are not too far away.
std::vector<DoubtfulCorner> doubtful_corners(const CalibrationProblem& single, const BundleState& state, std::size_t v,
                                             double limit_sigmas) {
  std::vector<DoubtfulCorner> doubtful;
  if (state.pose_of_view[v] < 0) return doubtful;
  const std::vector<Eigen::Vector2d> residuals = view_residuals(single, state, static_cast<int>(v));
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const double distance = residuals[i].norm() / single.views[v].observations[i].sigma_px;
    if (distance <= limit_sigmas && state.fates[v][i] == ObservationFate::kOutlier)
      doubtful.push_back({v, i, distance});
  }
  return doubtful;
}

// Solves with other corners in use; nothing where that fails.
std::optional<SolvedState> first_look(const CalibrationProblem& single, BundleState other,
                                      const CalibrateOptions& options, const SolvedState& here) {
  BundleOptions some_steps = bundle_options(options);
  some_steps.max_iterations = std::min(some_steps.max_iterations, kFirstLook);
  SolvedState solved{std::move(other), here.reasons, {}};
  solved.summary = solve_bundle(single, solved.state, some_steps);
  if (solved.summary.termination == Termination::kFailed) return {};
  return solved;
}

// Lets the outlier rule decide, and goes on from there if all corners fit better under the noise by which it does: one
// more in use may be a wrong one that bends the lens until the rule bears it.
bool take_if_better(const CalibrationProblem& single, SolvedState other, const CalibrateOptions& options,
                    SolvedState& solved) {
  other.summary = solve_without_outliers(single, other.state, options, false, other.reasons);
  if (other.summary.termination == Termination::kFailed || other.state.fates == solved.state.fates) return false;
  if (spoils_lens(single, solved.state, other.state)) return false;
  const double limit_sigmas = outlier_limit(options, robust_sigmas(single, other.state)[0]);
  if (!(all_squares(single, other.state, limit_sigmas) < all_squares(single, solved.state, limit_sigmas))) return false;
  solved = std::move(other);
  return true;
}

// Poses views that were lost under a lens that has moved since.
bool readmit_views(const CalibrationProblem& single, const CalibrateOptions& options, SolvedState& solved) {
  SolvedState other = solved;
  if (!give_second_chance(single, other.state, options, other.reasons)) return false;
  return take_if_better(single, std::move(other), options, solved);
}

// Takes in all doubtful corners.
bool readmit_corners(const CalibrationProblem& single, const CalibrateOptions& options, double limit_sigmas,
                     SolvedState& solved) {
  BundleState other = solved.state;
  bool any = false;
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    for (const DoubtfulCorner& doubtful : doubtful_corners(single, solved.state, v, limit_sigmas)) {
      other.fates[v][doubtful.corner] = ObservationFate::kUsed;
      any = true;
    }
  }
  if (!any) return false;
  std::optional<SolvedState> seen = first_look(single, std::move(other), options, solved);
  return seen && take_if_better(single, *std::move(seen), options, solved);
}

// The corners that may be taken in for another one of their view, the nearest first.
std::vector<DoubtfulCorner> exchangeable_corners(const CalibrationProblem& single, const BundleState& state,
                                                 double limit_sigmas) {
  std::vector<DoubtfulCorner> corners;
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    const bool few = count_used(state.fates[v]) <= kFewOfView;
    const double limit = few ? std::numeric_limits<double>::infinity() : limit_sigmas;
    std::ranges::copy(doubtful_corners(single, state, v, limit), std::back_inserter(corners));
  }
  std::ranges::stable_sort(corners, {}, &DoubtfulCorner::distance);
  return corners;
}

// Takes in one doubtful corner instead of one of its view that is in use: the pair that fits best. A solve that leads
// to plainly fewer corners in use is not followed: one more may come back at its end.
bool exchange_corners(const CalibrationProblem& single, const CalibrateOptions& options, double limit_sigmas,
                      SolvedState& solved) {
  const SolvedState here = solved;
  bool found = false;
  const auto try_pair = [&](std::size_t v, std::size_t in, std::size_t out) {
    BundleState exchanged = here.state;
    exchanged.fates[v][in] = ObservationFate::kUsed;
    exchanged.fates[v][out] = ObservationFate::kOutlier;
    std::optional<SolvedState> other = first_look(single, std::move(exchanged), options, here);
    if (!other) return;
    mark_outliers(single, other->state, options, other->reasons);
    const bool elsewhere = other->state.fates != here.state.fates;
    if (!elsewhere || count_used(other->state) + 1 < count_used(here.state)) return;
    other->summary = solve_without_outliers(single, other->state, options, false, other->reasons);
    if (!is_better(single, *other, solved, options)) return;
    solved = *std::move(other);
    found = true;
  };
  std::size_t pairs = 0;
  for (const DoubtfulCorner& in : exchangeable_corners(single, here.state, limit_sigmas)) {
    const std::vector<ObservationFate>& fates = here.state.fates[in.view];
    for (std::size_t out = 0; out < fates.size() && pairs < kMostPairs; ++out) {
      if (fates[out] != ObservationFate::kUsed) continue;
      try_pair(in.view, in.corner, out);
      ++pairs;
    }
  }
  return found;
}

}  // namespace

std::size_t count_used(const BundleState& state) {
  std::size_t used = 0;
  for (const std::vector<ObservationFate>& fates : state.fates) used += count_used(fates);
  return used;
}

bool swallows_noise(const CalibrationProblem& single, const BundleState& state) {
  std::size_t unknowns =
      6 * static_cast<std::size_t>(std::ranges::count_if(state.pose_of_view, [](int pose) { return pose >= 0; }));
  for (const ParameterBlock& block : parameter_blocks(single)) {
    if (block.kind == ParameterBlock::Kind::kIntrinsics) unknowns += block.free().size();
  }
  return count_used(state) <= kSwallowed * unknowns;
}

bool choose_corners_again(const CalibrationProblem& single, const CalibrateOptions& options, SolvedState& solved) {
  const bool few_views = single.views.size() <= kMostViews;
  if (few_views && (readmit_views(single, options, solved) || win_back_views(single, options, solved))) return true;
  if (!swallows_noise(single, solved.state)) return false;
  const double limit_sigmas = kReadmitted * options.outlier_sigma * robust_sigmas(single, solved.state)[0];
  if (readmit_corners(single, options, limit_sigmas, solved)) return true;
  return count_used(solved.state) <= kMostExchanged && exchange_corners(single, options, limit_sigmas, solved);
}

}  // namespace raybundle
