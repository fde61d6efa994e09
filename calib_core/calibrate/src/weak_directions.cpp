// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "weak_directions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "lens_certainty.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "subproblem.hpp"

namespace raybundle {
namespace {

constexpr std::ptrdiff_t kFewestDirections = 3;      // principal axes of the correlations
constexpr std::array kSigmas{2.0, 5.0, 12.0, 30.0};  // along each of them, to either side
constexpr std::array kTimesFocal{0.87, 1.15};        // a step to shorter and to longer ones
constexpr int kStepsOfFocal = 5;                     // to half and twice the focal length
constexpr int kSettlingAround = 8;                   // iterations of everything else around a focal length
constexpr int kFollowing = 10;                       // iterations of the boards

/// A step of one standard deviation of a camera's parameters, in the order of its model.
using Step = Eigen::VectorXd;

std::vector<Step> weakest_steps(const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> estimated;
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
    if (covariance(k, k) > 0) estimated.push_back(k);
  }
  if (estimated.empty() || !covariance.allFinite()) return {};
  // Of the correlations, so that no parameter counts for more because of its unit.
  const Eigen::VectorXd sigmas = covariance.diagonal()(estimated).cwiseSqrt(), inverse = sigmas.cwiseInverse();
  const Eigen::MatrixXd correlations = inverse.asDiagonal() * covariance(estimated, estimated) * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(correlations);
  std::vector<Step> steps;
  const std::ptrdiff_t together = (axes.eigenvalues().array() > 1.0).count();  // each varies more than one parameter
  const auto count = std::min(std::max(kFewestDirections, together), std::ssize(estimated));
  for (Eigen::Index axis = std::ssize(estimated) - 1; std::ssize(steps) < count; --axis) {
    Step& step = steps.emplace_back(Step::Zero(covariance.rows()));
    step(estimated) =
        std::sqrt(std::max(axes.eigenvalues()[axis], 0.0)) * sigmas.cwiseProduct(axes.eigenvectors().col(axis));
  }
  return steps;
}

// Whether no rule says anything of the camera's focal lengths.
bool focal_free(const CalibrationProblem& single) {
  return std::ranges::any_of(parameter_blocks(single), [](const ParameterBlock& block) {
    return block.kind == ParameterBlock::Kind::kIntrinsics && block.parameters[0].kind == ParameterRule::Kind::kFree &&
           block.parameters[1].kind == ParameterRule::Kind::kFree;
  });
}

}  // namespace

std::vector<CostedState> states_along_weakest(const CalibrationProblem& single, const BundleState& state, int threads) {
  CalibrationProblem boards_only = with_fixed_intrinsics(single, state);
  BundleOptions bundle;
  bundle.threads = threads;
  bundle.max_iterations = kFollowing;
  std::vector<CostedState> states;
  for (const Step& step : weakest_steps(covariance_of_lens(single, state, threads))) {
    for (const double sigmas : kSigmas) {
      for (const double side : {-1.0, 1.0}) {
        BundleState other = state;
        auto& parameters = other.cameras[0].parameters;
        parameters += side * sigmas * step;
        if (!(parameters[0] > 0) || !(parameters[1] > 0)) continue;
        boards_only.cameras[0].parameters = parameters;
        const BundleSummary summary = solve_bundle(boards_only, other, bundle);
        if (summary.termination == Termination::kFailed) continue;
        states.push_back({std::move(other), summary.final_cost});
      }
    }
  }
  return states;
}

std::vector<CostedState> states_of_other_focals(const CalibrationProblem& single, const BundleState& state,
                                                int threads) {
  if (!focal_free(single)) return {};
  CalibrationProblem focal_held = single;
  for (const char* focal : {".fx", ".fy"}) {
    focal_held.rules.push_back({single.cameras[0].name + focal, ParameterRule::Kind::kFixed, {}, 0.0});
  }
  BundleOptions bundle;
  bundle.threads = threads;
  bundle.max_iterations = kSettlingAround;
  std::vector<CostedState> states;
  for (const double times : kTimesFocal) {
    BundleState other = state;
    for (int step = 0; step < kStepsOfFocal; ++step) {
      Eigen::VectorXd& parameters = other.cameras[0].parameters;
      parameters.head<2>() *= times;
      for (BoardPose& pose : other.poses) pose.rig_from_target.translation *= times;
      focal_held.cameras[0].parameters = parameters;
      const BundleSummary summary = solve_bundle(focal_held, other, bundle);
      if (summary.termination == Termination::kFailed) break;
      states.push_back({other, summary.final_cost});
    }
  }
  return states;
}

}  // namespace raybundle
