// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace raybundle {

inline constexpr int kMostFixtures = 4;

/// What whoever installs the sensor knows of the car. Vehicle frame [m]: x forward to the dashboard, y left, z up, its
/// origin the passenger's H-point with the seat amid its travel.
///
/// Distances count from the vertical plane through the dashboard's rearmost edge. The safety zones lie behind it,
/// above the knees and as wide as the seat.
struct VehicleLayout {
  double dashboard_x_m = 0.70;
  double dashboard_top_m = 0.46;               ///< z
  double zone_floor_m = 0.30;                  ///< z; below are the knees of every passenger
  double zone_half_width_m = 0.32;             ///< |y|
  double critical_m = 0.20;                    ///< depth of the critical out-of-position zone (COOP)
  double out_of_position_m = 0.40;             ///< depth of both zones
  double track_m = 0.12;                       ///< the seat moves so far to the front and back
  double lift_m = 0.03;                        ///< and up and down
  double least_recline_rad = 12 * M_PI / 180;  ///< of the seat's back from the vertical, to the rear
  double most_recline_rad = 40 * M_PI / 180;
  double roof_m = 1.02;  ///< z
  /// Parts of the car that stand in the zones, such as a screen on the dashboard; empty boxes are none.
  std::array<Eigen::AlignedBox3d, kMostFixtures> fixtures = {};
};

}  // namespace raybundle
