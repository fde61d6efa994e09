// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/gaussian_beam.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {

double GaussianBeam::radius_m(double along_m) const {
  return std::hypot(waist_radius_m, divergence_rad * (along_m - waist_distance_m));
}

double GaussianBeam::irradiance_W_m2(const Eigen::Vector3d& place) const {
  const Eigen::Vector3d from_start = place - line.point;
  const double along = from_start.dot(line.direction);
  if (along <= 0) return 0;
  const double radius = radius_m(along), squared = radius * radius;
  const double away = std::max(0.0, from_start.squaredNorm() - along * along);
  return 2 * power_W / (M_PI * squared) * std::exp(-2 * away / squared);
}

}  // namespace raybundle
