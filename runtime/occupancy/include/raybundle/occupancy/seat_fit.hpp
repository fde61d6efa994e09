// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/seat.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

struct SeatFitOptions {
  double half_width_m = 0.11;  ///< of the seat's flat middle: bolsters rise beside it
  double tolerance_m = 0.03;   ///< of a point from a line that it belongs to, beside three of its sigmas
  int least_points = 12;       ///< on each line
  int iterations = 12;
};

/// A seat that was found.
struct SeatFit {
  SeatPose pose;
  bool found = false;  ///< both lines were seen, and their setting is one that the car allows
  int cushion_points = 0;
  int back_points = 0;
  Eigen::Vector2d bight_sigma_m = Eigen::Vector2d::Zero();  ///< by the points' scatter about the lines
  double recline_sigma_rad = 0.0;
  double planarity_m = 0.0;  ///< root mean square distance of their points from the two lines
};

/// Cushion and back as two lines in the longitudinal plane. They start from the seat amid its travel and grow: points
/// near a line join it, the line is fitted again, and what would leave the travel that the car allows is refused. Of
/// points before the seat, those of an occupant, none joins; a seat that is hidden is not found.
SeatFit fit_seat(const VehicleLayout& layout, const Scan& scan, const SeatFitOptions& options = {});

}  // namespace raybundle
