// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

struct ZoneOptions {
  double margin_m = 0.02;      ///< the zones count as deeper by this
  double dashboard_m = 0.02;   ///< what is nearer to the dashboard than this may be the dashboard
  double beyond_m = 0.15;      ///< above the dashboard the zones reach so far over it
  int least_points = 1;        ///< points in a zone before something is there; of dense points single ones are wrong
  double most_sigma_m = 0.05;  ///< less certain points are not counted
};

/// What is in the airbag's way.
struct ZoneCount {
  int critical = 0;         ///< points in the critical zone, COOP
  int out_of_position = 0;  ///< points in the outer zone, OOP
  bool anything = false;    ///< whether enough points are at the zones' height at all
  double distance_m = 0.0;  ///< from the dashboard's plane to the nearest of them, least_points - 1 left out
  double sigma_m = 0.0;     ///< of the distance
};

ZoneCount count_zones(const VehicleLayout& layout, const Scan& scan, const ZoneOptions& options = {});

}  // namespace raybundle
