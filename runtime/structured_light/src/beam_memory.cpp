// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/beam_memory.hpp"

#include <Eigen/LU>
#include <cmath>

namespace raybundle {
namespace {

constexpr double kLeastVariance = 1e-16;  // of an offset [m²] and of a slope: keeps exact beams finite

Eigen::Vector2d design(double along_m, double inverse_distance) {
  return {inverse_distance, along_m * inverse_distance};
}

}  // namespace

BeamMemory::BeamMemory(const BeamSet& set, int frames) : kept_(std::exp(-1.0 / frames)) {
  lines_.reserve(set.beams.size());
  for (const BeamGeometry& beam : set.beams) {
    Eigen::Matrix2d covariance;
    covariance << beam.variance[0], beam.variance[1], beam.variance[1], beam.variance[2];
    covariance.diagonal().array() += kLeastVariance;
    Line line;
    line.prior = covariance.inverse();
    lines_.push_back(line);
  }
}

BeamMemory::Off BeamMemory::off(int beam, double along_m, double inverse_distance) const {
  const Line& line = lines_[beam];
  const Eigen::Vector2d at = design(along_m, inverse_distance);
  const Eigen::Matrix2d covariance = (line.prior + line.information).inverse();
  return {at.dot(covariance * line.right), at.dot(covariance * at), at.transpose() * covariance * line.prior};
}

void BeamMemory::fade() {
  for (Line& line : lines_) {
    line.information *= kept_;
    line.right *= kept_;
  }
}

void BeamMemory::learn(int beam, double along_m, double inverse_distance, double off, double variance) {
  const Eigen::Vector2d at = design(along_m, inverse_distance);
  lines_[beam].information += at * at.transpose() / variance;
  lines_[beam].right += at * (off / variance);
}

}  // namespace raybundle
