// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/zones.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "raybundle/occupancy/box.hpp"

namespace raybundle {
namespace {

constexpr int kMostLeastPoints = 64;
constexpr double kCell_m = 0.06, kAboveDashboard_m = 0.15;
constexpr int kAlong = 24, kAcross = 16, kUp = 16;  // cells; what is beyond shares the outermost ones

struct Nearest {
  double distance_m = INFINITY;
  double sigma_m = 0.0;
};

// How a point lies to the zones.
struct InZones {
  bool counts = false;  // at their height, and clear of the dashboard
  double distance_m = 0.0, sigma_m = 0.0;
  int cell = 0;
};

InZones in_zones(const VehicleLayout& layout, const Scan& scan, const ScenePoint& point, const ZoneOptions& options) {
  const Eigen::Vector3d& x = point.x_in_vehicle;
  if (x.z() < layout.zone_floor_m || std::abs(x.y()) > layout.zone_half_width_m) return {};
  const Eigen::Vector3d ray = (x - scan.viewpoint_in_vehicle).normalized();
  const double to_plane = layout.dashboard_x_m - x.x(), sigma_x = point.sigma_m * std::abs(ray.x());
  const double above = x.z() - layout.dashboard_top_m, sigma_z = point.sigma_m * std::abs(ray.z());
  // Above the dashboard everything counts, even beyond its edge; at its height, what is clear of it.
  const bool clear = to_plane > std::max(options.dashboard_m, 3.0 * sigma_x) ||
                     (above > std::max(options.dashboard_m, 3.0 * sigma_z) && to_plane > -options.beyond_m);
  const auto index = [](double length_m, int cells) {
    return std::clamp(static_cast<int>(std::floor(length_m / kCell_m)), 0, cells - 1);
  };
  const int along = index(to_plane + options.beyond_m, kAlong),
            across = index(x.y() + layout.zone_half_width_m, kAcross), up = index(x.z() - layout.zone_floor_m, kUp);
  return {clear, std::max(0.0, to_plane), sigma_x, (along * kAcross + across) * kUp + up};
}

}  // namespace

int rays_through_zones(const VehicleLayout& layout, const Scan& scan) {
  const double half = layout.zone_half_width_m, x = layout.dashboard_x_m;
  const Box zones{.low = {x - layout.out_of_position_m, -half, layout.zone_floor_m},
                  .high = {x, half, layout.dashboard_top_m + kAboveDashboard_m}};
  return count_rays(zones, scan).passed;
}

ZoneCount count_zones(const VehicleLayout& layout, const Scan& scan, const ZoneOptions& options) {
  std::array<std::uint16_t, kAlong * kAcross * kUp> in_cell{};
  for (const ScenePoint& point : scan.points) {
    const InZones at = in_zones(layout, scan, point, options);
    if (at.counts && in_cell[at.cell] < UINT16_MAX) ++in_cell[at.cell];
  }
  const int kept = std::clamp(options.least_points, 1, kMostLeastPoints);
  std::array<Nearest, kMostLeastPoints> nearest{};  // sorted
  ZoneCount count;
  for (const ScenePoint& point : scan.points) {
    const InZones at = in_zones(layout, scan, point, options);
    if (!at.counts || in_cell[at.cell] < kept) continue;
    const bool critical = at.distance_m < layout.critical_m + options.margin_m;
    count.critical += critical;
    count.out_of_position += !critical && at.distance_m < layout.out_of_position_m + options.margin_m;
    if (!(at.distance_m < nearest[kept - 1].distance_m)) continue;
    int place = kept - 1;
    for (; place > 0 && nearest[place - 1].distance_m > at.distance_m; --place) nearest[place] = nearest[place - 1];
    nearest[place] = {at.distance_m, at.sigma_m};
  }
  count.anything = std::isfinite(nearest[kept - 1].distance_m);
  if (count.anything) count.distance_m = nearest[kept - 1].distance_m, count.sigma_m = nearest[kept - 1].sigma_m;
  return count;
}

}  // namespace raybundle
