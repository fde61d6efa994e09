// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/zones.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace raybundle {
namespace {

constexpr int kMostLeastPoints = 64;

struct Nearest {
  double distance_m = INFINITY;
  double sigma_m = 0.0;
};

}  // namespace

ZoneCount count_zones(const VehicleLayout& layout, const Scan& scan, const ZoneOptions& options) {
  const int kept = std::clamp(options.least_points, 1, kMostLeastPoints);
  std::array<Nearest, kMostLeastPoints> nearest{};  // sorted
  ZoneCount count;
  for (const ScenePoint& point : scan.points) {
    const Eigen::Vector3d& x = point.x_in_vehicle;
    const double to_plane = layout.dashboard_x_m - x.x(), distance = std::max(0.0, to_plane);
    // Above the dashboard everything counts, even beyond its edge; at its height, what is clear of it.
    const bool clear = x.z() > layout.dashboard_top_m + options.dashboard_m ? to_plane > -options.beyond_m
                                                                            : to_plane > options.dashboard_m;
    if (x.z() < layout.zone_floor_m || std::abs(x.y()) > layout.zone_half_width_m || !clear ||
        point.sigma_m > options.most_sigma_m) {
      continue;
    }
    count.critical += distance < layout.critical_m + options.margin_m;
    count.out_of_position +=
        distance >= layout.critical_m + options.margin_m && distance < layout.out_of_position_m + options.margin_m;
    if (!(distance < nearest[kept - 1].distance_m)) continue;
    int at = kept - 1;
    for (; at > 0 && nearest[at - 1].distance_m > distance; --at) nearest[at] = nearest[at - 1];
    const double along_x = std::abs((x - scan.viewpoint_in_vehicle).normalized().x());
    nearest[at] = {distance, point.sigma_m * along_x};
  }
  if (count.critical < kept) count.out_of_position += std::exchange(count.critical, 0);
  if (count.out_of_position < kept) count.out_of_position = 0;
  count.anything = std::isfinite(nearest[kept - 1].distance_m);
  if (count.anything) count.distance_m = nearest[kept - 1].distance_m, count.sigma_m = nearest[kept - 1].sigma_m;
  return count;
}

}  // namespace raybundle
