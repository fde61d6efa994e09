// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "prior_weight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "raybundle/bundle/parameters.hpp"
#include "raybundle/calibrate/lens_prior.hpp"

namespace raybundle {
namespace {

constexpr double kLeastNoise = 1e-6;       // of a corner's sigma: less is rounding, and no prior weighs against it
constexpr double kContradictSigmas = 5.0;  // of both together

}  // namespace

bool has_priors(const CalibrationProblem& problem) {
  return std::ranges::any_of(problem.rules,
                             [](const ParameterRule& rule) { return rule.kind == ParameterRule::Kind::kPrior; });
}

double corner_noise(const CalibrationProblem& problem, const CalibrationResult& result) {
  double chi2 = 0.0;
  auto freedom = -static_cast<double>(result.calibration.covariance.names.size() + 6 * result.poses.size());
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    for (std::size_t i = 0; i < result.views[v].fates.size(); ++i) {
      if (result.views[v].fates[i] != ObservationFate::kUsed) continue;
      const double sigma_px = problem.views[v].observations[i].sigma_px;
      chi2 += result.views[v].residuals_px[i].squaredNorm() / (sigma_px * sigma_px);
      freedom += 2.0;
    }
  }
  return freedom > 0.0 ? std::max(kLeastNoise, std::sqrt(chi2 / freedom)) : 1.0;
}

CalibrationProblem with_priors_for(const CalibrationProblem& problem, double noise) {
  CalibrationProblem weighed = problem;
  for (ParameterRule& rule : weighed.rules) {
    if (rule.kind == ParameterRule::Kind::kPrior) rule.sigma /= noise;
  }
  return weighed;
}

CalibrationProblem with_overruling_priors_kept(const CalibrationProblem& problem, const CalibrationResult& result) {
  constexpr double kTold = 0.02;  // by the corners: of the information on a parameter
  CalibrationProblem kept = problem;
  for (ParameterRule& rule : kept.rules) {
    if (rule.kind != ParameterRule::Kind::kPrior || !rule.value) continue;
    CalibrationProblem alone;
    alone.cameras = problem.cameras;
    alone.targets = problem.targets;
    alone.rules = {rule};
    for (const ParameterBlock& block : parameter_blocks(alone)) {
      for (const int i : block.with_prior()) {
        const double sigma = result.calibration.covariance.sigma(block.parameters[i].name);
        if (sigma * sigma > (1.0 - kTold) * rule.sigma * rule.sigma) rule.kind = ParameterRule::Kind::kFixed;
      }
    }
  }
  return kept;
}

// The solution lies between prior and corners, and its variance tells where: from what the corners alone say the prior
// is farther away by s² / (s² - v), and the sigma of that distance is s² / sqrt(s² - v), s the prior's sigma and v the
// variance of the solution.
std::vector<std::string> contradicted_priors(const CalibrationProblem& problem, const BundleState& state,
                                             const CalibrationResult& result) {
  if (!has_priors(problem)) return {};
  std::vector<std::string> warnings;
  const double noise = corner_noise(problem, result);
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    if (block.with_prior().empty()) continue;
    const PriorResidual prior = prior_residual(block, prior_mean(problem, state, block), current_values(state, block));
    for (std::size_t k = 0; k < block.with_prior().size(); ++k) {
      const Parameter& parameter = block.parameters[block.with_prior()[k]];
      if (has_lens_prior(problem, parameter)) continue;
      const double sigma = result.calibration.covariance.sigma(parameter.name) / noise;  // at the corners' stated ones
      const double told = 1.0 - sigma * sigma / (parameter.sigma * parameter.sigma);
      if (!(sigma > 0.0 && told > 0.0)) continue;
      const double apart = std::abs(prior.residual[static_cast<Eigen::Index>(k)]) / (noise * std::sqrt(told));
      if (apart < kContradictSigmas) continue;
      warnings.push_back(
          fmt::format("the prior on {} lies {:.0f} sigmas, of both together, from what the corners say: one of them is "
                      "wrong; check the prior's value and unit, or give it a larger sigma",
                      parameter.name, apart));
    }
  }
  return warnings;
}

}  // namespace raybundle
