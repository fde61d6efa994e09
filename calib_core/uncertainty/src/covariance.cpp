// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/covariance.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <numeric>

namespace raybundle {
namespace {

// Of the scaled information, whose entries are good to some 1e-16 times their number: below, nothing was seen.
constexpr double kUnseen = 1e-15;

// Above, the weakest direction is known 1e5 times worse than its parameters would be one at a time.
constexpr double kIllConditioned = 1e10;

// Names of the parameters that make up a direction, strongest first: those with at least a tenth of the largest share.
std::vector<std::string> parameters_of(const std::vector<std::string>& names, const Eigen::VectorXd& direction) {
  std::vector<int> order(names.size());
  std::iota(order.begin(), order.end(), 0);
  const auto share = [&](int i) { return std::abs(direction[i]); };
  std::ranges::stable_sort(order, std::ranges::greater{}, share);
  std::vector<std::string> strongest;
  for (int i : order) {
    if (share(i) >= 0.1 * share(order.front())) strongest.push_back(names[i]);
  }
  return strongest;
}

}  // namespace

CovarianceResult covariance(const ReducedInformation& information) {
  CovarianceResult result;
  result.covariance.names = information.names;
  const int freedom = information.residuals - information.parameters;
  if (freedom > 0) result.variance_factor = information.chi2 / freedom;
  const Eigen::Index size = information.information.rows();
  result.covariance.matrix.resize(size, size);
  if (size == 0) return result;

  const Eigen::VectorXd diagonal = information.information.diagonal();
  const Eigen::VectorXd scale =
      (diagonal.array() > 0.0).select(diagonal.array().max(std::numeric_limits<double>::min()).rsqrt(), 1.0);
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information.information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  const double smallest = kUnseen * static_cast<double>(size);
  result.unseen = eigen.eigenvalues()[0] <= smallest;
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(smallest);  // ascending
  result.condition_number = values[size - 1] / values[0];
  if (result.condition_number > kIllConditioned) {
    result.weak_parameters = parameters_of(information.names, eigen.eigenvectors().col(0));
  }
  const Eigen::MatrixXd half =
      scale.asDiagonal() * eigen.eigenvectors() * values.cwiseInverse().cwiseSqrt().asDiagonal();
  result.covariance.matrix = result.variance_factor * half * half.transpose();
  return result;
}

}  // namespace raybundle
