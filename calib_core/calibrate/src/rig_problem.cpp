// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "rig_problem.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "raybundle/bundle/parameters.hpp"
#include "raybundle/geometry/error.hpp"
#include "robust_solve.hpp"

namespace raybundle {
namespace {

// A camera counts by the noise that it has alone: the sigmas of corners change against those of other cameras, and all
// together stay. Otherwise a blurred camera spoils a sharp one.
void weigh_cameras(RigProblem& rig) {
  if (rig.cameras.size() == 1) {
    rig.sigma_scales = {1.0};
    return;
  }
  double squares = 0.0, corners = 0.0;
  for (const TargetView& view : rig.sub.problem.views) {
    const auto count = static_cast<double>(view.observations.size());
    squares += count * std::pow(std::max(rig.sigmas_alone[view.camera], kExactNoise), 2);
    corners += count;
  }
  const double all = std::sqrt(squares / corners);
  for (const double sigma : rig.sigmas_alone) rig.sigma_scales.push_back(std::max(sigma, kExactNoise) / all);
  for (TargetView& view : rig.sub.problem.views) {
    for (Observation& seen : view.observations) {
      seen.sigma_px = std::max(rig.sigma_scales[view.camera] * seen.sigma_px, kSmallestSigma_px);
    }
  }
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    rig.sigmas_alone[c] /= rig.sigma_scales[c];
    for (ParameterRule& prior : rig.sub.problem.lens_priors) {
      if (prior.pattern.starts_with(rig.sub.problem.cameras[c].name + ".")) prior.sigma *= rig.sigma_scales[c];
    }
  }
}

}  // namespace

RigProblem rig_problem(CalibrationProblem& whole, const CamerasAlone& alone) {
  RigProblem rig;
  for (int c = 0; c < static_cast<int>(whole.cameras.size()); ++c) {
    if (alone.cameras[c]) rig.cameras.push_back(c);
  }
  if (rig.cameras.empty()) throw Error(ErrorKind::kNotEnoughData, alone.why_not.front());
  rig.sub = take_cameras(whole, rig.cameras);
  CalibrationProblem& problem = rig.sub.problem;
  rig.own_rules = problem.rules.size();
  std::ranges::copy_if(alone.lens_priors, std::back_inserter(problem.lens_priors),
                       [&](const ParameterRule& prior) { return matches_any(prior, problem); });
  for (const int c : rig.cameras) {
    std::ranges::copy(alone.given_up[c], std::back_inserter(problem.rules));
    rig.sigmas_alone.push_back(alone.sigmas[c]);
  }
  weigh_cameras(rig);
  for (const int v : rig.sub.views) {
    rig.camera_from_target.push_back(alone.camera_from_target[v]);
    rig.mirrored.push_back(alone.mirrored[v]);
    rig.fates.push_back(alone.fates[v]);
    rig.reasons.push_back(alone.reasons[v]);
  }
  return rig;
}

}  // namespace raybundle
