// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/fixtures.hpp"

#include <algorithm>

namespace raybundle {

Scan without_fixtures(const VehicleLayout& layout, const Scan& scan, double margin_m, std::vector<ScenePoint>& kept) {
  if (std::ranges::all_of(layout.fixtures, &Eigen::AlignedBox3d::isEmpty)) return scan;
  kept.clear();
  for (const ScenePoint& point : scan.points) {
    const double margin = std::max(margin_m, 3.0 * point.sigma_m);
    const auto is_on = [&](const Eigen::AlignedBox3d& fixture) {
      return !fixture.isEmpty() && fixture.squaredExteriorDistance(point.x_in_vehicle) <= margin * margin;
    };
    if (std::ranges::none_of(layout.fixtures, is_on)) kept.push_back(point);
  }
  return {scan.viewpoint_in_vehicle, kept, scan.rays, scan.state};
}

}  // namespace raybundle
