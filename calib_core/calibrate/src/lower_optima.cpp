// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lower_optima.hpp"

#include <algorithm>
#include <utility>

#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/geometry/threads.hpp"
#include "subproblem.hpp"

namespace raybundle {
namespace {

constexpr double kLower = 1e-7;         // relative: by which another optimum's cost must be lower
constexpr double kPromising = 1.01;     // times the cost, after the first look
constexpr int kFirstLook = 30;          // iterations
constexpr double kFirstSettled = 1e-9;  // relative: to gain, far below kLower
constexpr std::size_t kFollowed = 2;    // solves that are followed to their end
constexpr std::size_t kBudget = 6000;   // corners that decide whether there is a lower optimum

/// Another optimum, or a place on the way to one.
struct OtherSolve {
  BundleState state;
  BundleSummary summary;
};

// Solves that know nothing of one another: the threads are shared out among them.
std::vector<OtherSolve> solve_side_by_side(const CalibrationProblem& single, std::vector<CostedState>& starts,
                                           BundleOptions bundle) {
  const int side_by_side = std::clamp(static_cast<int>(starts.size()), 1, bundle.threads);
  bundle.threads /= side_by_side;
  std::vector<OtherSolve> solves(starts.size());
  for_each_index(starts.size(), side_by_side, [&](std::size_t i) {
    solves[i].state = std::move(starts[i].state);
    solves[i].summary = solve_bundle(single, solves[i].state, bundle);
  });
  return solves;
}

std::vector<CostedState> with_cameras(const BundleState& state, const std::vector<Camera>& cameras) {
  std::vector<CostedState> states;
  for (const Camera& camera : cameras) {
    states.push_back({state, 0.0});
    states.back().state.cameras[0] = camera;
  }
  return states;
}

// Solves on from other states: all of them for some steps, or until what is left to gain does not count, then the lowest
// to their end. Those that are lower than where the state was, the lowest first.
std::vector<OtherSolve> lower_optima(const CalibrationProblem& single, const BundleState& state, double cost,
                                     std::vector<CostedState>& others, BundleOptions bundle) {
  const int most_iterations = bundle.max_iterations;
  const double settled = std::exchange(bundle.settled, kFirstSettled);
  bundle.max_iterations = std::min(most_iterations, kFirstLook);
  const auto by_cost = [](const OtherSolve& solve) { return solve.summary.final_cost; };
  std::vector<OtherSolve> solves;
  std::vector<CostedState> come_to;
  for (OtherSolve& other : solve_side_by_side(single, others, bundle)) {
    if (other.summary.termination == Termination::kFailed) continue;
    if (spoils_lens(single, state, other.state)) continue;  // or they would crowd out those that may be followed
    come_to.push_back({other.state, other.summary.final_cost});
    const bool at_rest = other.summary.termination != Termination::kIterationLimit;
    if (other.summary.final_cost < (at_rest ? 1.0 - kLower : kPromising) * cost) solves.push_back(std::move(other));
  }
  others = std::move(come_to);
  std::ranges::stable_sort(solves, {}, by_cost);
  if (solves.size() > kFollowed) solves.resize(kFollowed);
  bundle.max_iterations = most_iterations;
  bundle.settled = settled;
  for (OtherSolve& other : solves) other.summary = solve_bundle(single, other.state, bundle);
  std::erase_if(solves, [&](const OtherSolve& other) {
    return other.summary.termination == Termination::kFailed || !(other.summary.final_cost < (1.0 - kLower) * cost) ||
           spoils_lens(single, state, other.state);
  });
  std::ranges::stable_sort(solves, {}, by_cost);
  return solves;
}

// Moves to the lowest of them, if there is one; whether it did.
bool take_lowest(std::vector<OtherSolve> lower, SolvedState& solved) {
  if (lower.empty()) return false;
  solved.state = std::move(lower.front().state);
  solved.summary = lower.front().summary;
  return true;
}

}  // namespace

bool move_to_lower(const CalibrationProblem& single, const std::vector<Camera>& others, const CalibrateOptions& options,
                   SolvedState& solved) {
  if (others.empty()) return false;
  const BundleOptions bundle = bundle_options(options);
  BundleState fewer = with_fewer_views(solved.state, kBudget);
  const bool all = fewer.pose_of_view == solved.state.pose_of_view;
  const double cost = all ? solved.summary.final_cost : solve_bundle(single, fewer, bundle).final_cost;
  std::vector<CostedState> starts = with_cameras(fewer, others);
  std::vector<OtherSolve> lower = lower_optima(single, fewer, cost, starts, bundle);
  if (!all && !lower.empty()) {
    starts = with_cameras(solved.state, {lower.front().state.cameras[0]});
    lower = lower_optima(single, solved.state, solved.summary.final_cost, starts, bundle);
  }
  return take_lowest(std::move(lower), solved);
}

bool move_to_lower(const CalibrationProblem& single, std::vector<CostedState>& others, const CalibrateOptions& options,
                   SolvedState& solved) {
  const double cost = solved.summary.final_cost;
  return take_lowest(lower_optima(single, solved.state, cost, others, bundle_options(options)), solved);
}

}  // namespace raybundle
