// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/seat.hpp"

#include <cmath>

namespace raybundle {

Eigen::Vector2d SeatPose::cushion_forward() const { return {std::cos(cushion_pitch_rad), std::sin(cushion_pitch_rad)}; }

Eigen::Vector2d SeatPose::back_up() const { return {-std::sin(recline_rad), std::cos(recline_rad)}; }

double SeatPose::above_cushion(const Eigen::Vector3d& x_in_vehicle) const {
  const Eigen::Vector2d along = cushion_forward();
  return along.x() * (x_in_vehicle.z() - bight.y()) - along.y() * (x_in_vehicle.x() - bight.x());
}

double SeatPose::before_back(const Eigen::Vector3d& x_in_vehicle) const {
  const Eigen::Vector2d up = back_up();
  return up.y() * (x_in_vehicle.x() - bight.x()) - up.x() * (x_in_vehicle.z() - bight.y());
}

}  // namespace raybundle
