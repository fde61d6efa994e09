// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_source.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "raybundle/geometry/quantile.hpp"

namespace raybundle {
namespace {

// Halfway between the places where two lines come nearest to each other; nothing when they are nearly parallel.
std::optional<Eigen::Vector3d> closest_point(const Line3& a, const Line3& b) {
  const double cosine = a.direction.dot(b.direction);
  const double sine2 = 1.0 - cosine * cosine;
  if (sine2 < 1e-4) return std::nullopt;
  const Eigen::Vector3d arm = b.point - a.point;
  const double on_a = (arm.dot(a.direction) - cosine * arm.dot(b.direction)) / sine2;
  const double on_b = (cosine * arm.dot(a.direction) - arm.dot(b.direction)) / sine2;
  return 0.5 * (a.at(on_a) + b.at(on_b));
}

std::vector<double> distances_from(const std::vector<Line3>& lines, const Eigen::Vector3d& apex) {
  std::vector<double> distances;
  for (const Line3& line : lines) distances.push_back(distance_between(line, apex));
  return distances;
}

}  // namespace

std::optional<BeamSource> source_of(const std::vector<Line3>& lines) {
  constexpr std::size_t kFewestLines = 4;  // two meet anywhere; more are a projector
  if (lines.size() < kFewestLines) return std::nullopt;
  BeamSource source{.spread_m = INFINITY};
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t k = i + 1; k < lines.size(); ++k) {
      const std::optional<Eigen::Vector3d> place = closest_point(lines[i], lines[k]);
      if (!place) continue;
      std::vector<double> distances = distances_from(lines, *place);
      const double spread_m = median(distances);
      if (spread_m < source.spread_m) source = {*place, spread_m};
    }
  }
  if (!std::isfinite(source.spread_m)) return std::nullopt;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const std::vector<double> distances = distances_from(lines, source.apex);
    std::vector<double> by_size = distances;
    source.spread_m = std::max(1e-4, median(by_size));
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const Line3& line = lines[i];
      const double weight = 1.0 / (1.0 + std::pow(distances[i] / source.spread_m, 2));
      const Eigen::Matrix3d across_line = Eigen::Matrix3d::Identity() - line.direction * line.direction.transpose();
      normal += weight * across_line;
      right += weight * across_line * line.point;
    }
    source.apex = normal.ldlt().solve(right);
  }
  return source;
}

}  // namespace raybundle
