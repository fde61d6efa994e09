// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/target_spacing.hpp"

#include <algorithm>
#include <limits>

#include "raybundle/geometry/quantile.hpp"

namespace raybundle {

double spacing_m(const Target& target) {
  std::vector<double> distances;
  for (const TargetPoint& point : target.points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const TargetPoint& other : target.points) {
      if (other.id == point.id) continue;
      nearest = std::min(nearest, (other.x_in_target - point.x_in_target).norm());
    }
    distances.push_back(nearest);
  }
  return median(distances);
}

}  // namespace raybundle
