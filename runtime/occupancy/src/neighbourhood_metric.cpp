// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "neighbourhood_metric.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace raybundle {
namespace {

constexpr int kBatch = 256, kReferences = 2048;  // cases of a step, and those that may be their neighbours

// A sample of the cases.
struct Sample {
  Eigen::MatrixXf attributes;
  std::vector<int> indices;

  Sample(const Eigen::MatrixXf& all, int count, std::mt19937_64& random) : attributes(all.rows(), count) {
    for (int i = 0; i < count; ++i) {
      indices.push_back(static_cast<int>(random() % static_cast<std::uint64_t>(all.cols())));
      attributes.col(i) = all.col(indices.back());
    }
  }
};

// Of the mean over the batch of log p, p being the share of a case's neighbourhood that is of its class.
Eigen::MatrixXf gradient(const Eigen::MatrixXf& metric, const Sample& batch, const Sample& others,
                         const std::vector<std::uint8_t>& classes) {
  const Eigen::MatrixXf z = metric * batch.attributes, z_others = metric * others.attributes;
  Eigen::MatrixXf weights = 2.0F * z.transpose() * z_others;  // batch × others
  weights.colwise() -= z.colwise().squaredNorm().transpose();
  weights.rowwise() -= z_others.colwise().squaredNorm();  // minus the squared distances
  for (Eigen::Index i = 0; i < weights.rows(); ++i) {
    for (Eigen::Index j = 0; j < weights.cols(); ++j) {
      if (others.indices[j] == batch.indices[i]) weights(i, j) = -INFINITY;
    }
    weights.row(i) = (weights.row(i).array() - weights.row(i).maxCoeff()).exp();
    weights.row(i) /= weights.row(i).sum();
    float own = 1e-6F;
    for (Eigen::Index j = 0; j < weights.cols(); ++j) {
      if (classes[others.indices[j]] == classes[batch.indices[i]]) own += weights(i, j);
    }
    for (Eigen::Index j = 0; j < weights.cols(); ++j) {
      if (classes[others.indices[j]] == classes[batch.indices[i]]) weights(i, j) -= weights(i, j) / own;
    }
  }
  // Sum of weight (z_i - z_j)(x_i - x_j)^T, without the differences.
  const Eigen::MatrixXf z_weighted = z * weights, back = z_others * weights.transpose();
  const Eigen::VectorXf rows = weights.rowwise().sum(), columns = weights.colwise().sum();
  return (2.0F / static_cast<float>(weights.rows())) *
         ((z * rows.asDiagonal() - back) * batch.attributes.transpose() +
          (z_others * columns.asDiagonal() - z_weighted) * others.attributes.transpose());
}

}  // namespace

Eigen::MatrixXd neighbourhood_metric(Eigen::MatrixXd metric, const Eigen::MatrixXd& attributes,
                                     const std::vector<std::uint8_t>& classes, const MetricSearch& search) {
  constexpr float kFirst = 0.9F, kSecond = 0.99F, kLeast = 1e-8F;
  // Attributes in the units in which the start value weighs them alike, so that one length of step suits all.
  const Eigen::VectorXd units =
      metric.colwise().norm().transpose().cwiseMax(1e-12) / std::sqrt(static_cast<double>(metric.rows()));
  const Eigen::MatrixXf all = (units.asDiagonal() * (attributes.colwise() - attributes.rowwise().mean())).cast<float>();
  Eigen::MatrixXf turned = (metric * units.cwiseInverse().asDiagonal()).cast<float>();
  const auto cases = static_cast<int>(all.cols());
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(turned.rows(), turned.cols()), square = mean;
  std::mt19937_64 random(1);
  for (int step = 1; step <= search.steps; ++step) {
    const Sample batch(all, std::min(kBatch, cases), random), others(all, std::min(kReferences, cases), random);
    Eigen::MatrixXf up = gradient(turned, batch, others, classes);
    up -= static_cast<float>(search.decay) * turned;
    mean = kFirst * mean + (1 - kFirst) * up;
    square = kSecond * square + (1 - kSecond) * up.cwiseAbs2();
    const auto t = static_cast<float>(step);
    const float rate = 0.05F * (1.0F - 0.95F * t / static_cast<float>(search.steps)) *
                       std::sqrt(1 - std::pow(kSecond, t)) / (1 - std::pow(kFirst, t));
    turned += rate * (mean.array() / (square.array().sqrt() + kLeast)).matrix();
  }
  return turned.cast<double>() * units.asDiagonal();
}

}  // namespace raybundle
