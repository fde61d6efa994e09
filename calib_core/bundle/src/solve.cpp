// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "normal_equations.hpp"
#include "raybundle/bundle/bundle.hpp"

namespace raybundle {
namespace {

constexpr double kStepTolerance = 1e-12;  // of a step that ends the solve, relative to the unknowns
constexpr double kSmallestGain = 1e-3;    // of a step that is taken: decrease over what was predicted
constexpr double kFirstRadius = 1e9;      // hardly any damping
constexpr double kToldGain = 0.01;        // distance of a gain from one: so near, the model is right and damping slows
constexpr double kNearOptimum = 1e-3;     // of the cost: what a step gains there
constexpr double kPlainGrowth = 1e3;      // of the radius where both hold
constexpr double kLeftToGain = 1e-6;      // of the cost: a solve that rests with more to gain has been blocked
constexpr double kPlainGain = 1e-6;       // of the cost: so small a step goes where the quadratic model says, mostly
constexpr double kLastGain = 0.5;         // of what it says the last step must gain at least: valleys are curved
constexpr double kRounding = 1e-12;       // of the cost: what its sum may be off
constexpr double kSlowFall = 0.1;         // of what steps gain, from one to the next, along the weakest directions
constexpr double kNoMove_sigma = 1e-3;    // by which no unknown may be off the optimum for want of a further step

// How far the quadratic model is trusted: the inverse of the damping. Source: Nielsen, "Damping parameter in
// Marquardt's method", 1999, as in Ceres, with its constants; but the first radius is that of starts which are near,
// and it grows faster near the optimum, where damping only keeps the weakest directions waiting.
class TrustRegion {
 public:
  double radius() const { return radius_; }
  bool hardly_damps() const { return radius_ >= 0.1 * kFirstRadius; }
  bool vanished() const { return radius_ < 1e-32; }

  /// @param gain           decrease of the cost over what was predicted
  /// @param relative_gain  decrease over the cost
  void accept(double gain, double relative_gain) {
    const double nielsen = 1.0 / std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3));
    const bool plain = !refused_ && relative_gain < kNearOptimum && std::abs(gain - 1.0) < kToldGain;
    radius_ = std::min(1e16, radius_ * (plain ? kPlainGrowth : nielsen));
    shrink_ = 2.0;
  }
  void refuse() {
    radius_ /= shrink_;
    shrink_ *= 2.0;
    refused_ = true;
  }

 private:
  double radius_ = kFirstRadius;
  double shrink_ = 2.0;
  bool refused_ = false;  // ever
};

double squared_size(const Unknowns& unknowns) {
  double sum = 0.0;
  for (const Eigen::VectorXd& intrinsics : unknowns.intrinsics) sum += intrinsics.squaredNorm();
  for (const Rigid3& pose : unknowns.camera_from_rig) sum += 1.0 + pose.translation.squaredNorm();
  for (const Rigid3& pose : unknowns.rig_from_target) sum += 1.0 + pose.translation.squaredNorm();
  for (const Line3& beam : unknowns.beams) sum += 1.0 + beam.point.squaredNorm();
  return sum;
}

// Decrease of the cost that is still to be had behind a step, by the one and all after it. What steps gain falls as it
// did before, but not forever: strong directions settle first, and along weak ones Gauss-Newton converges linearly, the
// slower the more noise there is. Infinite where nothing tells how it falls.
double left_behind(const Step& step, double promised_before) {
  const double fall = std::max(step.predicted_decrease / promised_before, kSlowFall);
  return fall < 1.0 ? step.predicted_decrease * fall / (1.0 - fall) : std::numeric_limits<double>::infinity();
}

// Relative decrease of the cost that moves no unknown by more than kNoMove_sigma: by k sigmas the cost rises by k²/2
// times the variance of a residual, which is at least twice the cost over the number of residuals.
double unnoticed(const NormalEquations& equations) {
  return kNoMove_sigma * kNoMove_sigma / static_cast<double>(equations.residuals());
}

bool negligible(const Step& step, const Unknowns& unknowns) {
  double sum = step.parameters.squaredNorm();
  for (const Eigen::Matrix<double, 6, 1>& motion : step.motions) sum += motion.squaredNorm();
  sum += step.beams.squaredNorm();
  return sum <= kStepTolerance * kStepTolerance * squared_size(unknowns);
}

// Levenberg-Marquardt from the unknowns to the optimum.
BundleSummary minimize(NormalEquations& equations, Unknowns& unknowns, const BundleOptions& options) {
  BundleSummary summary;
  Linearization here;
  if (!equations.linearize(unknowns, here) || !std::isfinite(here.cost)) {
    summary.message = "the start has corners or dots that its camera models do not project";
    return summary;
  }
  const auto finish = [&](Termination termination, const char* message) {
    summary.termination = termination;
    summary.message = message;
    summary.final_cost = here.cost;
    return summary;
  };
  summary.initial_cost = here.cost;
  const double left_at_most = std::max(options.settled, unnoticed(equations));
  Linearization there;
  TrustRegion region;
  double promised_before = 0.0;  // by the step that led here; 0: there is none, or one was refused since
  bool refused_unseen = false;   // a step to where the cost cannot be told
  const auto rest = [&](const char* message) {
    const auto onward = refused_unseen ? equations.step(unknowns, here, kFirstRadius) : std::nullopt;
    return onward && onward->predicted_decrease > kLeftToGain * here.cost
               ? finish(Termination::kBlocked, "the optimum lies where a camera model does not project")
               : finish(Termination::kConverged, message);
  };
  while (!region.vanished()) {
    if (summary.iterations == options.max_iterations)
      return finish(Termination::kIterationLimit, "iteration limit reached");
    const std::optional<Step> step = equations.step(unknowns, here, region.radius());
    ++summary.iterations;
    if (!step) {
      region.refuse();
      if (region.vanished()) return finish(Termination::kFailed, "the normal equations could not be solved");
      continue;
    }
    if (negligible(*step, unknowns)) return rest("the steps have become negligible");
    if (step->predicted_decrease <= options.settled * here.cost) {
      return rest("no step lowers the cost any more");
    }
    Unknowns candidate = equations.moved(unknowns, *step);
    const bool plain = step->predicted_decrease <= kPlainGain * here.cost && region.hardly_damps() && !refused_unseen;
    if (plain && left_behind(*step, promised_before) <= left_at_most * here.cost) {
      const std::optional<double> cost = equations.cost(candidate);
      if (cost && here.cost - *cost >= kLastGain * step->predicted_decrease - kRounding * here.cost) {
        unknowns = std::move(candidate);
        here.cost = *cost;
        return finish(Termination::kConverged, "no step would lower the cost any more");
      }
    }
    const bool projectable = equations.linearize(candidate, there);
    const double decrease = here.cost - there.cost;
    const double gain = decrease / step->predicted_decrease;
    if (projectable && gain > kSmallestGain) {
      region.accept(gain, decrease / here.cost);
      promised_before = step->predicted_decrease;
      std::swap(here, there);
      std::swap(unknowns, candidate);
    } else {
      region.refuse();
      promised_before = 0.0;
      refused_unseen |= !projectable;
    }
    if (projectable && std::abs(decrease) <= options.settled * here.cost) {
      return rest("the cost does not change any more");
    }
  }
  return rest("no step lowers the cost, however small");
}

std::string refusals_of(const CalibrationProblem& problem, const NormalEquations& equations) {
  const auto most = std::ranges::max_element(equations.refusals());
  if (most == equations.refusals().end() || *most == 0) return {};
  const TargetView& view = problem.views[most - equations.refusals().begin()];
  return "; " + std::to_string(*most) + " steps were refused because they would have moved corners or dots of " +
         view_name(problem, view) + " to where its camera model does not project";
}

}  // namespace

BundleSummary solve_bundle(const CalibrationProblem& problem, BundleState& state, const BundleOptions& options) {
  apply_fixed_values(problem, parameter_blocks(problem), state);
  NormalEquations equations(problem, state, options);
  if (equations.empty()) {
    return {.termination = Termination::kFailed, .message = "no observation is in use"};
  }
  Unknowns unknowns(state);
  centre_beams(equations.dots(), unknowns);
  BundleSummary summary = minimize(equations, unknowns, options);
  summary.message += refusals_of(problem, equations);
  if (summary.termination == Termination::kFailed) return summary;
  centre_beams(equations.dots(), unknowns);
  unknowns.store(state);
  return summary;
}

}  // namespace raybundle
