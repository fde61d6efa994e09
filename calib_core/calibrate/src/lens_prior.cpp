// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/lens_prior.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

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

// Of a ratio of two polynomials: each coefficient of the profile.
std::vector<ExpectedCoefficient> expected_of_ratio(ModelId model, double field_rad) {
  std::vector<ExpectedCoefficient> expected;
  if (!(field_rad > 0.0 && field_rad < M_PI_2)) return expected;
  const double field = std::pow(std::tan(field_rad), 2);  // squared radius in the plane
  for (const std::string_view name : parameter_names(model)) {
    if (name.front() != 'k') continue;
    expected.push_back({name, 0.0, std::max(1.0, std::pow(rounded(field), -power_of(name)))});
  }
  return expected;
}

// What a model's definition says.
std::vector<ExpectedCoefficient> expected_of_model(ModelId model) {
  return with_model(model, []<CameraModel M>() -> std::vector<ExpectedCoefficient> {
    if constexpr (requires { M::kExpected; }) {
      static_assert(std::ranges::all_of(M::kExpected, [](const ExpectedCoefficient& coefficient) {
        return std::ranges::find(M::kShapeNames, coefficient.name) != M::kShapeNames.end();
      }));
      return {M::kExpected.begin(), M::kExpected.end()};
    }
    return {};
  });
}

// Of a camera's coefficients; none without views, which would tell the noise.
void add_priors(const CalibrationProblem& problem, const BundleState& state, int camera, double noise,
                std::vector<ParameterRule>& priors) {
  const ModelId model = problem.cameras[camera].model;
  if (!std::isfinite(noise)) return;
  std::vector<ExpectedCoefficient> expected = expected_of_model(model);
  if (can_have_pole(model)) {
    std::ranges::copy(expected_of_ratio(model, farthest_corner_rad(problem, state, camera)),
                      std::back_inserter(expected));
  }
  for (const ExpectedCoefficient& coefficient : expected) {
    priors.push_back({problem.cameras[camera].name + "." + std::string(coefficient.name), ParameterRule::Kind::kPrior,
                      coefficient.value, coefficient.sigma / rounded(std::max(noise, kLeastNoise))});
  }
}

bool may_have_prior(const ProblemCamera& camera) {
  return can_have_pole(camera.model) || !expected_of_model(camera.model).empty();
}

bool same(const ParameterRule& a, const ParameterRule& b) { return a.pattern == b.pattern && a.sigma == b.sigma; }

}  // namespace

bool weigh_lens_priors(CalibrationProblem& problem, const BundleState& state) {
  if (std::ranges::none_of(problem.cameras, may_have_prior)) return false;
  const std::vector<double> noise = robust_sigmas(problem, state);
  std::vector<ParameterRule> priors;
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) add_priors(problem, state, c, noise[c], priors);
  if (std::ranges::equal(priors, problem.lens_priors, same)) return false;
  problem.lens_priors = std::move(priors);
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
