// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

struct ZoneOptions {
  double margin_m = 0.02;     ///< the zones count as deeper by this
  double dashboard_m = 0.01;  ///< what is nearer to the dashboard than this, or than three sigmas, may be it
  double beyond_m = 0.15;     ///< above the dashboard the zones reach so far over it
  int least_points = 1;       ///< in a cell of 6 cm before they are believed: of dense points single ones are wrong
};

/// For points of a matcher: its windows let the dashboard's edge grow by 2 px, and of some 80 pixels of a cell twelve
/// are somebody, as where the zones' floor cuts a knee, and not wrong matches.
inline constexpr ZoneOptions kDenseZones{.dashboard_m = 0.04, .least_points = 12};

/// What is in the airbag's way.
struct ZoneCount {
  int critical = 0;         ///< points in the critical zone, COOP
  int out_of_position = 0;  ///< points in the outer zone, OOP
  bool anything = false;    ///< whether any believed point is at the zones' height
  double distance_m = 0.0;  ///< from the dashboard's plane to the least_points-th nearest of them
  double sigma_m = 0.0;     ///< of that point
};

/// Rays that cross both zones and end beyond: they prove that what they crossed is free.
int rays_through_zones(const VehicleLayout& layout, const Scan& scan);

ZoneCount count_zones(const VehicleLayout& layout, const Scan& scan, const ZoneOptions& options = {});

}  // namespace raybundle
