// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "grown_lens.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "camera_corners.hpp"
#include "corner_choice.hpp"
#include "raybundle/calibrate/lens_domain.hpp"
#include "raybundle/initialize/other_optima.hpp"

namespace raybundle {
namespace {

constexpr double kLower = 1e-7;              // relative: by which the cost of the same corners must be lower
constexpr double kFitOfWidth = 0.025;        // of the image: a right corner fits the simple lens within this
constexpr std::ptrdiff_t kSeveral = 3;       // corners of one view: hardly all of them are wrong where nothing tells
constexpr std::size_t kMostCorners = 10000;  // of more the rim holds enough, and solves are dear

// Whether several corners of a view were left out that lie farther from the principal point than all that are in use:
// there the lens was not fitted to anything.
bool leaves_out_rim(const CalibrationProblem& single, const BundleState& state) {
  const Eigen::Vector2d middle = state.cameras[0].parameters.segment<2>(2);
  const auto radius = [&](std::size_t v, std::size_t i) {
    return (single.views[v].observations[i].pixel - middle).norm();
  };
  double farthest = 0.0;
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    for (std::size_t i = 0; i < state.fates[v].size(); ++i) {
      if (state.fates[v][i] == ObservationFate::kUsed) farthest = std::max(farthest, radius(v, i));
    }
  }
  for (std::size_t v = 0; v < single.views.size(); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    std::ptrdiff_t beyond = 0;
    for (std::size_t i = 0; i < state.fates[v].size(); ++i) {
      beyond += state.fates[v][i] != ObservationFate::kUsed && radius(v, i) > farthest;
    }
    if (beyond >= kSeveral) return true;
  }
  return false;
}

bool may_lie_elsewhere(const CalibrationProblem& single, const CameraOptimum& optimum) {
  const BundleState& state = optimum.solved.state;
  if (!can_have_pole(state.cameras[0].model) || count_used(state) > kMostCorners) return false;
  return knows_loosely(optimum) || swallows_noise(single, state) || leaves_out_rim(single, state);
}

// Lets the coefficients go one after the other.
void grow(const CalibrationProblem& single, const std::vector<int>& higher, const CalibrateOptions& options,
          SolvedState& solved) {
  const std::vector<std::string_view> names = parameter_names(single.cameras[0].model);
  CalibrationProblem simpler = single;
  for (auto k = higher.rbegin(); k != higher.rend(); ++k) {
    const std::string name = single.cameras[0].name + "." + std::string(names[*k]);
    simpler.rules.push_back({name, ParameterRule::Kind::kFixed, 0.0, 0.0});
  }
  double off_px = kFitOfWidth * std::max(single.cameras[0].size.width, single.cameras[0].size.height);
  auto& [state, reasons, summary] = solved;
  for (std::size_t step = 0; step <= higher.size(); ++step) {
    give_second_chance(simpler, state, options, reasons);
    solve_robustly(simpler, state, options, std::exchange(off_px, 0.0));
    summary = solve_without_outliers(simpler, state, options, false, reasons);
    if (step < higher.size()) simpler.rules.pop_back();
  }
}

}  // namespace

std::vector<int> higher_coefficients(ModelId model) {
  return with_model(model, []<CameraModel M>() {
    std::vector<int> higher;
    for (int k = 1; k < kShapeSize<M>; ++k) {
      if (M::kStartShape[static_cast<std::size_t>(k)] == 0.0) higher.push_back(kParameterCount<M> - kShapeSize<M> + k);
    }
    return higher;
  });
}

bool grow_lens(const CalibrationProblem& single, const CalibrateOptions& options, CameraOptimum& optimum) {
  if (!may_lie_elsewhere(single, optimum)) return false;
  SolvedState& here = optimum.solved;
  const Camera& lens = here.state.cameras[0];
  const std::vector<int> higher = higher_coefficients(lens.model);
  const CameraCorners corners = used_corners(single, here.state, 0);
  SolvedState other = here;
  other.state.cameras[0] = fitted_anew(lens, corners.rays, corners.pixels, higher);
  mark_projectable(single, other.state);
  grow(single, higher, options, other);
  const bool same_corners = other.state.fates == here.state.fates;
  if (same_corners && !(other.summary.final_cost < (1.0 - kLower) * here.summary.final_cost)) return false;
  if (!is_better(single, other, here, options)) return false;
  here = std::move(other);
  return true;
}

}  // namespace raybundle
