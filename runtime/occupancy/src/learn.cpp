// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/learn.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

// Of an attribute's variance, the part that counts as scatter within classes at least.
constexpr double kLeastWithin = 1e-3;

void check(const LabelledCases& cases, const LearnOptions& options) {
  if (cases.attributes.cols() != static_cast<Eigen::Index>(cases.classes.size()) || cases.attributes.rows() < 1 ||
      cases.class_names.size() > kMostClasses) {
    throw Error(ErrorKind::kBadInput, "attributes and classes of the cases to learn differ in number");
  }
  if (!cases.attributes.allFinite()) throw Error(ErrorKind::kBadInput, "an attribute to learn is not finite");
  for (std::size_t c = 0; c < cases.class_names.size(); ++c) {
    const auto count = std::ranges::count(cases.classes, static_cast<std::uint8_t>(c));
    if (count <= options.neighbours) {
      throw Error(ErrorKind::kNotEnoughData, "class '" + cases.class_names[c] + "' has " + std::to_string(count) +
                                                 " cases, and more than " + std::to_string(options.neighbours) +
                                                 " are needed: add scenes of it");
    }
  }
}

// Scatter of the attributes about the mean of their class.
Eigen::MatrixXd scatter_within_classes(const LabelledCases& cases) {
  const Eigen::Index size = cases.attributes.rows();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, static_cast<Eigen::Index>(cases.class_names.size()));
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
  scatter.diagonal().array() += 1e-12;

  CaseBase base{.attribute_set = cases.attribute_set,
                .class_names = cases.class_names,
                .metric_from_attributes =
                    scatter.llt().matrixL().solve(Eigen::MatrixXd::Identity(scatter.rows(), scatter.cols())),
                .cases = {},
                .classes = cases.classes,
                .neighbours = options.neighbours,
                .farthest = 0.0,
                .least_share = options.least_share};
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
