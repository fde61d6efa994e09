// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/lens_prior.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "camera_corners.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "robust_solve.hpp"

namespace raybundle {
namespace {

constexpr double kLeastNoise = 1e-6;  // of a corner's sigma: less is rounding, and the prior weighs nothing

// To a power of the square root of two.
double rounded(double value) { return std::exp2(0.5 * std::round(2.0 * std::log2(value))); }

// Half the power of the radius that k1 to k6 stand before.
int power_of(std::string_view coefficient) { return (coefficient[1] - '1') % 3 + 1; }

}  // namespace

bool weigh_lens_prior(CalibrationProblem& problem, const BundleState& state, int camera) {
  const ModelId model = problem.cameras[camera].model;
  if (!can_have_pole(model)) return false;
  const double noise = robust_sigmas(problem, state)[camera], field_rad = farthest_corner_rad(problem, state, camera);
  if (!std::isfinite(noise) || !(field_rad > 0.0 && field_rad < M_PI_2)) return false;
  const double field = std::pow(std::tan(field_rad), 2);  // squared radius in the plane
  std::vector<ParameterRule> priors;
  for (const std::string_view name : parameter_names(model)) {
    if (name.front() != 'k') continue;
    const double sigma = std::max(1.0, std::pow(rounded(field), -power_of(name)));
    priors.push_back({problem.cameras[camera].name + "." + std::string(name), ParameterRule::Kind::kPrior, 0.0,
                      sigma / rounded(std::max(noise, kLeastNoise))});
  }
  std::vector<ParameterRule>& all = problem.lens_priors;
  const auto same = [](const ParameterRule& a, const ParameterRule& b) {
    return a.pattern == b.pattern && a.sigma == b.sigma;
  };
  if (std::ranges::search(all, priors, same).begin() != all.end()) return false;
  std::erase_if(all, [&](const ParameterRule& prior) {
    return std::ranges::find(priors, prior.pattern, &ParameterRule::pattern) != priors.end();
  });
  all.insert(all.end(), priors.begin(), priors.end());
  return true;
}

bool has_lens_prior(const CalibrationProblem& problem, const Parameter& parameter) {
  return parameter.kind == ParameterRule::Kind::kPrior &&
         std::ranges::any_of(problem.lens_priors, [&](const ParameterRule& prior) {
           return prior.pattern == parameter.name && prior.value == parameter.value && prior.sigma == parameter.sigma;
         });
}

std::vector<ParameterRule> lens_priors_in_force(const CalibrationProblem& problem) {
  std::vector<ParameterRule> priors;
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    for (const Parameter& parameter : block.parameters) {
      if (!has_lens_prior(problem, parameter)) continue;
      priors.push_back({parameter.name, ParameterRule::Kind::kPrior, parameter.value, parameter.sigma});
    }
  }
  return priors;
}

}  // namespace raybundle
