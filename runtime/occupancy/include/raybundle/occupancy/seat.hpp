// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

/// How the seat is set: the flat middles of cushion and back are two lines in the vehicle's longitudinal plane.
struct SeatPose {
  Eigen::Vector2d bight = {-0.14, -0.11};  ///< [m] x and z of where cushion and back meet
  double recline_rad = 0.4;                ///< of the back from the vertical, to the rear
  double cushion_pitch_rad = 0.22;         ///< of the cushion, its front edge up

  Eigen::Vector2d cushion_forward() const;  ///< x and z, of unit length
  Eigen::Vector2d back_up() const;
  double above_cushion(const Eigen::Vector3d& x_in_vehicle) const;  ///< [m] perpendicular to it
  double before_back(const Eigen::Vector3d& x_in_vehicle) const;
};

}  // namespace raybundle
