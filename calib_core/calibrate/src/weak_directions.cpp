// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "weak_directions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "raybundle/bundle/information.hpp"
#include "raybundle/uncertainty/covariance.hpp"

namespace raybundle {
namespace {

constexpr int kDirections = 3;                       // principal axes of the correlations
constexpr std::array kSigmas{2.0, 5.0, 12.0, 30.0};  // along each of them, to either side
constexpr int kFollowing = 10;                       // iterations of the boards

/// A step of one standard deviation of a camera's parameters, in the order of its model.
using Step = Eigen::VectorXd;

std::vector<Step> weakest_steps(const CalibrationProblem& single, const BundleState& state, int threads) {
  BundleOptions bundle;
  bundle.threads = threads;
  const Covariance known = covariance(reduced_information(single, state, bundle)).covariance;
  if (known.names.empty() || !known.matrix.allFinite() || !(known.matrix.diagonal().minCoeff() > 0)) return {};
  // Of the correlations, so that no parameter counts for more because of its unit.
  const Eigen::VectorXd sigmas = known.matrix.diagonal().cwiseSqrt(), inverse = sigmas.cwiseInverse();
  const Eigen::MatrixXd correlations = inverse.asDiagonal() * known.matrix * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(correlations);
  const std::vector<std::string_view> names = parameter_names(state.cameras[0].model);
  std::vector<Step> steps;
  const Eigen::Index count = std::min<Eigen::Index>(kDirections, axes.eigenvalues().size());
  for (Eigen::Index axis = axes.eigenvalues().size() - 1; std::ssize(steps) < count; --axis) {
    const Eigen::VectorXd along =
        std::sqrt(std::max(axes.eigenvalues()[axis], 0.0)) * sigmas.cwiseProduct(axes.eigenvectors().col(axis));
    Step& step = steps.emplace_back(Step::Zero(std::ssize(names)));
    for (Eigen::Index k = 0; k < along.size(); ++k) {
      const auto found = std::ranges::find_if(names, [&](std::string_view name) {
        return known.names[static_cast<std::size_t>(k)] == single.cameras[0].name + "." + std::string(name);
      });
      if (found != names.end()) step[found - names.begin()] = along[k];
    }
  }
  return steps;
}

}  // namespace

std::vector<BundleState> states_along_weakest(const CalibrationProblem& single, const BundleState& state, int threads) {
  CalibrationProblem boards_only = single;
  boards_only.rules.push_back({"*.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0});
  BundleOptions bundle;
  bundle.threads = threads;
  bundle.max_iterations = kFollowing;
  std::vector<BundleState> states;
  for (const Step& step : weakest_steps(single, state, threads)) {
    for (const double sigmas : kSigmas) {
      for (const double side : {-1.0, 1.0}) {
        BundleState other = state;
        auto& parameters = other.cameras[0].parameters;
        parameters += side * sigmas * step;
        if (!(parameters[0] > 0) || !(parameters[1] > 0)) continue;
        boards_only.cameras[0].parameters = parameters;
        if (solve_bundle(boards_only, other, bundle).termination == Termination::kFailed) continue;
        states.push_back(std::move(other));
      }
    }
  }
  return states;
}

}  // namespace raybundle
