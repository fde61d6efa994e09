// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/drift.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "pose_information.hpp"
#include "sensitivity.hpp"

namespace raybundle {
namespace {

// What one half of the frames says: the step from the common solution to its own, and how sure it is of it.
struct Half {
  Eigen::VectorXd step;
  Eigen::MatrixXd covariance;
};

// Normal equations for the parameters that a covariance names, when the boards' poses may follow freely.
struct Sum {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

std::optional<Half> solved(const Sum& sum) {
  const Eigen::VectorXd diagonal = sum.information.diagonal();
  if (diagonal.size() == 0 || !(diagonal.minCoeff() > 0.0)) return std::nullopt;
  const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> factor(scale.asDiagonal() * sum.information * scale.asDiagonal());
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 1e-12)) return std::nullopt;
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(diagonal.size(), diagonal.size()));
  Half half{{}, scale.asDiagonal() * inverse * scale.asDiagonal()};
  half.step = -(half.covariance * sum.gradient);
  return half;
}

}  // namespace

std::vector<Drift> drift_between_halves(const CalibrationProblem& problem, const CalibrationResult& result) {
  const Calibration& calibration = result.calibration;
  std::map<int, std::vector<ViewData>> by_pose;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (result.views[v].pose < 0) continue;
    const std::string& name = problem.cameras[problem.views[v].camera].name;
    const auto camera = std::ranges::find(calibration.cameras, name, &RigCamera::name) - calibration.cameras.begin();
    by_pose[result.views[v].pose].push_back(used_corners(problem, result, v, static_cast<int>(camera)));
  }
  std::vector<int> frames;
  for (const auto& [pose, views] : by_pose) frames.push_back(result.poses[pose].frame);
  if (frames.empty()) return {};
  std::ranges::sort(frames);
  const int middle = frames[frames.size() / 2];

  const auto size = static_cast<Eigen::Index>(calibration.covariance.names.size());
  std::array<Sum, 2> sums;
  sums.fill({Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)});
  for (const auto& [pose, views] : by_pose) {
    const Eigen::MatrixXd rows = rows_beside_pose(calibration, views, result.poses[pose].rig_from_target);
    const auto by_parameters = rows.leftCols(size);
    Sum& sum = sums[result.poses[pose].frame < middle ? 0 : 1];
    sum.information += by_parameters.transpose() * by_parameters;
    sum.gradient += by_parameters.transpose() * rows.col(size);
  }
  const std::optional<Half> first = solved(sums[0]), second = solved(sums[1]);
  if (!first || !second) return {};
  std::vector<Drift> drifts;
  for (const RigCamera& camera : calibration.cameras) {
    const std::vector<std::string> names = intrinsic_names(camera);
    const std::vector<int> places = calibration.covariance.places_of(names);
    for (int k = 0; k < 4; ++k) {  // fx fy cx cy
      const int i = places[k];
      if (i < 0) continue;
      const double variance = result.variance_factor * (first->covariance(i, i) + second->covariance(i, i));
      drifts.push_back({names[k], second->step[i] - first->step[i], std::sqrt(variance)});
    }
  }
  return drifts;
}

}  // namespace raybundle
