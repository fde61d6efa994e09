// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/learn.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "neighbourhood_metric.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

// Of an attribute's variance, the part that counts as scatter within classes at least.
constexpr double kLeastWithin = 1e-3;

void check(const LabelledCases& cases, const LearnOptions& options) {
  if (cases.attributes.cols() != static_cast<Eigen::Index>(cases.classes.size()) ||
      cases.actions.size() != cases.classes.size() || cases.attributes.rows() < 1 ||
      cases.situations.size() > kMostClasses) {
    throw Error(ErrorKind::kBadInput, "attributes and classes of the cases to learn differ in number");
  }
  if (!cases.attributes.allFinite()) throw Error(ErrorKind::kBadInput, "an attribute to learn is not finite");
  for (std::size_t c = 0; c < cases.situations.size(); ++c) {
    const auto count = std::ranges::count(cases.classes, static_cast<std::uint8_t>(c));
    if (count <= options.neighbours) {
      throw Error(ErrorKind::kNotEnoughData, "class '" + cases.situations[c].name + "' has " + std::to_string(count) +
                                                 " cases, and more than " + std::to_string(options.neighbours) +
                                                 " are needed: add scenes of it");
    }
  }
}

// Scatter of the attributes about the mean of their class.
Eigen::MatrixXd scatter_within_classes(const LabelledCases& cases) {
  const Eigen::Index size = cases.attributes.rows();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, static_cast<Eigen::Index>(cases.situations.size()));
  Eigen::VectorXd count = Eigen::VectorXd::Zero(mean.cols());
  for (Eigen::Index n = 0; n < cases.attributes.cols(); ++n) {
    mean.col(cases.classes[n]) += cases.attributes.col(n);
    count[cases.classes[n]] += 1.0;
  }
  mean = mean * count.cwiseInverse().asDiagonal();
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index n = 0; n < cases.attributes.cols(); ++n) {
    const Eigen::VectorXd off = cases.attributes.col(n) - mean.col(cases.classes[n]);
    scatter += off * off.transpose();
  }
  return scatter / static_cast<double>(cases.attributes.cols());
}

// The directions of the whitened space in which the cases spread most over their scatter within classes.
Eigen::MatrixXd most_telling(const Eigen::MatrixXd& whitening, const LabelledCases& cases, int size) {
  const Eigen::MatrixXd centred = cases.attributes.colwise() - cases.attributes.rowwise().mean();
  const Eigen::MatrixXd white = whitening * centred;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spread(white * white.transpose());
  const Eigen::Index kept = std::min<Eigen::Index>(size, white.rows());
  return spread.eigenvectors().rightCols(kept).transpose() * whitening;
}

}  // namespace

CaseBase learn(const LabelledCases& cases, const LearnOptions& options) {
  check(cases, options);
  Eigen::MatrixXd scatter = scatter_within_classes(cases);
  const Eigen::VectorXd variance = scatter.diagonal();
  scatter *= 1.0 - options.metric_shrinkage;
  // An attribute that is constant within every learnt class must not count for infinitely much when it varies later.
  const Eigen::VectorXd centre = cases.attributes.rowwise().mean();
  const Eigen::VectorXd total =
      (cases.attributes.colwise() - centre).rowwise().squaredNorm() / static_cast<double>(cases.attributes.cols());
  scatter.diagonal() += options.metric_shrinkage * variance + kLeastWithin * total;
  // One that never varies at all tells nothing; any unit will do.
  for (Eigen::Index i = 0; i < total.size(); ++i) {
    if (total[i] < 1e-12) scatter(i, i) = 1.0;
  }

  const Eigen::MatrixXd whitening =
      scatter.llt().matrixL().solve(Eigen::MatrixXd::Identity(scatter.rows(), scatter.cols()));
  CaseBase base{.attribute_set = cases.attribute_set,
                .situations = cases.situations,
                .group_names = cases.group_names,
                .metric_from_attributes =
                    neighbourhood_metric(most_telling(whitening, cases, options.metric_size), cases.attributes,
                                         cases.classes, {.steps = options.metric_steps, .decay = options.metric_decay}),
                .cases = {},
                .classes = cases.classes,
                .actions = cases.actions,
                .neighbours = options.neighbours,
                .farthest = 0.0};
  base.cases = base.metric_from_attributes * cases.attributes;

  std::vector<double> distances(cases.classes.size());
  for (std::size_t n = 0; n < distances.size(); ++n) {
    distances[n] = classify_left_out(base, static_cast<int>(n)).distance;
  }
  std::ranges::sort(distances);
  const auto at = static_cast<std::size_t>(options.known_share * static_cast<double>(distances.size() - 1));
  base.farthest = distances[at];
  base.check();
  return base;
}

}  // namespace raybundle
