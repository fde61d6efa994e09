// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "kept_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "prior_weight.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/parameter_names.hpp"

namespace raybundle {
namespace {

constexpr double kMuchLarger = 1.2;  // residuals
constexpr double kManySigmas = 5.0;

bool keeps_value(const ParameterRule& rule) { return rule.kind == ParameterRule::Kind::kFixed && rule.value; }

// What the corners say of a parameter that is kept elsewhere.
struct Contradiction {
  std::string name;
  double kept = 0.0, free = 0.0, sigma = 0.0;
  double sigmas() const { return std::abs(kept - free) / sigma; }
  bool left_out() const { return kept == 0.0; }  // of the model, for good reasons
};

// The worst, by how the frames scatter where that is known: nothing where no kept parameter is told by corners.
std::optional<Contradiction> worst_contradiction(const CalibrationProblem& problem, const Calibration& freed) {
  const Covariance& known = freed.covariance_by_frame ? *freed.covariance_by_frame : freed.covariance;
  const std::map<std::string, double> values = parameter_values(freed);
  std::optional<Contradiction> worst;
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    for (const Parameter& parameter : block.parameters) {
      if (parameter.kind != ParameterRule::Kind::kFixed || !parameter.value) continue;
      const auto free = values.find(parameter.name);
      const double sigma = known.sigma(parameter.name);
      if (free == values.end() || !(sigma > 0.0)) continue;
      const Contradiction here{parameter.name, *parameter.value, free->second, sigma};
      const auto weight = [](const Contradiction& each) { return std::pair(each.left_out() ? 0 : 1, each.sigmas()); };
      if (!worst || weight(here) > weight(*worst)) worst = here;
    }
  }
  return worst;
}

}  // namespace

void require_values(const CalibrationProblem& problem) {
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    const bool of_lens = block.kind == ParameterBlock::Kind::kIntrinsics;
    const bool of_place = block.kind == ParameterBlock::Kind::kCameraFromRig && block.owner > 0;
    if (!of_lens && !of_place) continue;
    const ProblemCamera& camera = problem.cameras[block.owner];
    if (of_lens ? camera.parameters.has_value() : camera.camera_from_rig.has_value()) continue;
    for (const Parameter& parameter : block.parameters) {
      if (parameter.kind == ParameterRule::Kind::kFree || parameter.value) continue;
      throw Error(
          ErrorKind::kBadInput,
          fmt::format("'{0}' is to be kept, but at which value? Write {0}=VALUE, or give start values (--start)",
                      parameter.name));
    }
  }
}

bool keeps_values(const CalibrationProblem& problem) { return std::ranges::any_of(problem.rules, keeps_value); }

CalibrationProblem without_kept_values(const CalibrationProblem& problem) {
  CalibrationProblem freed = problem;
  std::erase_if(freed.rules, keeps_value);
  return freed;
}

std::vector<std::string> contradictions(const CalibrationProblem& problem, const CalibrationResult& result,
                                        const CalibrationProblem& freed, const CalibrationResult& of_freed) {
  const double times = corner_noise(problem, result) / corner_noise(freed, of_freed);
  const std::optional<Contradiction> worst = worst_contradiction(problem, of_freed.calibration);
  const bool elsewhere = worst && !worst->left_out() && worst->sigmas() > kManySigmas;
  if (!worst || (times < kMuchLarger && !elsewhere)) return {};
  return {
      fmt::format("{} is kept at {:g}, where the corners say {:g} ± {:.2g}, {:.0f} sigmas away, and fit {:.3g} times "
                  "worse with all values that are kept; check the value and its unit, or free it",
                  worst->name, worst->kept, worst->free, worst->sigma, worst->sigmas(), times)};
}

}  // namespace raybundle
