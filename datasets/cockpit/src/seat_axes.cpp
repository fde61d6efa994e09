// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "seat_axes.hpp"

#include <Eigen/LU>
#include <cmath>

namespace raybundle {

SeatAxes axes_of(const SeatSetting& seat) {
  const double pitch_cosine = std::cos(seat.cushion_pitch_rad), pitch_sine = std::sin(seat.cushion_pitch_rad);
  const double back_cosine = std::cos(seat.recline_rad), back_sine = std::sin(seat.recline_rad);
  return {seat.bight,
          {pitch_cosine, 0, pitch_sine},
          {-pitch_sine, 0, pitch_cosine},
          {-back_sine, 0, back_cosine},
          {back_cosine, 0, back_sine}};
}

SeatSetting seat_setting_of(const Eigen::Vector3d& h_point, double recline_rad, double cushion_pitch_rad,
                            double above_cushion_m, double before_back_m) {
  SeatSetting seat{h_point, Eigen::Vector3d::Zero(), recline_rad, cushion_pitch_rad};
  const SeatAxes axes = axes_of(seat);
  Eigen::Matrix2d planes;
  planes << axes.cushion_normal.x(), axes.cushion_normal.z(), axes.back_normal.x(), axes.back_normal.z();
  const Eigen::Vector2d from_bight = planes.inverse() * Eigen::Vector2d(above_cushion_m, before_back_m);
  seat.bight = {h_point.x() - from_bight.x(), h_point.y(), h_point.z() - from_bight.y()};
  return seat;
}

}  // namespace raybundle
