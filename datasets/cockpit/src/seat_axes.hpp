// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/cockpit/truth.hpp"

namespace raybundle {

/// Axes of a seat's two planes in the vehicle frame, all of unit length; the bight is their origin.
struct SeatAxes {
  Eigen::Vector3d bight;
  Eigen::Vector3d cushion_forward, cushion_normal;  ///< along the cushion to its front edge, and up from it
  Eigen::Vector3d back_up, back_normal;             ///< along the back to the headrest, and forward from it
};

SeatAxes axes_of(const SeatSetting& seat);

/// The setting of a seat whose planes lie so far from the H-point.
SeatSetting seat_setting_of(const Eigen::Vector3d& h_point, double recline_rad, double cushion_pitch_rad,
                            double above_cushion_m, double before_back_m);

}  // namespace raybundle
