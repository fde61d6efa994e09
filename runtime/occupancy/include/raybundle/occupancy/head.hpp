// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/seat.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

/// What heads are like, and what is believed to be one. Sizes follow ISO 7250: adults of both sexes and schoolchildren.
struct HeadOptions {
  Eigen::Vector3d semi_axes_m = {0.094, 0.077, 0.112};  ///< to the face, to the ear, to the crown
  double size_sigma = 0.05;                             ///< standard deviation of a factor of all axes
  double turn_sigma_rad = 0.7;                          ///< of heads about the vertical, against looking ahead
  double nod_rad = 0.15;                                ///< commonly, the face down
  double nod_sigma_rad = 0.4;
  double hair_m = 0.004;             ///< head and hair are centred so far behind the head
  double hair_sigma_m = 0.006;       ///< of the centre: how hair lies is not known
  double shape_sigma_m = 0.006;      ///< of faces and hair from the ellipsoid
  double alike_points = 16.0;        ///< so many points err alike, as neighbouring pixels of a matcher do
  double least_from_bight_m = 0.48;  ///< a head is so far from where cushion and back meet,
  double least_above_cushion_m = 0.30;
  double least_before_back_m = 0.10;  ///< headrests are nearer
  double least_from_side_m = 0.06;    ///< of its centre, from the zones' sides: it is over the seat
  int least_points = 60;
  double least_filled = 0.70;
  double least_clear = 0.50;
  double most_size = 1.15;    ///< of the factor
  double most_misfit = 1.12;  ///< what is no ellipsoid differs more from one
};

/// A head that was found.
struct Head {
  bool found = false;
  Eigen::Vector3d front = Eigen::Vector3d::Zero();  ///< [m] where the line from the sensor to the centre enters it
  Eigen::Matrix3d front_covariance_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();         ///< [m] of the head's ellipsoid, in the vehicle frame
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of the centre
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Zero();    ///< to the face, to the ear, to the crown
  Eigen::Matrix3d vehicle_from_head = Eigen::Matrix3d::Identity();  ///< columns: towards face, left ear, crown
  int points = 0;                                                   ///< on it
  double residual_m = 0.0;                                          ///< their root mean square distance from it
  double misfit = 0.0;                                              ///< the same in sigmas of points and of shape
  double filled = 0.0;  ///< share of the rays through a ball of its size that end on it
  double clear = 0.0;   ///< share of the rays just beside the upper half of that ball that end far behind
};

/// The head of whoever is on the seat, from the dense points of one frame.
///
/// Where points are as if on the front of a ball that stands free, an ellipsoid of the size of heads is fitted: points
/// on it pull its surface, rays that pass beside it push it. Told are its front, the middle of the surface that the
/// sensor sees, and its centre, a point amid the head: the front is measured, the centre lies behind it by a size that
/// one view hardly shows, and is less sure by that. What is no head in size, in place above the seat, or in how it
/// stands free, is not found; of several, as hands and knees may be, it is the highest. Without heap; the same bits on
/// every run.
///
/// @param seat  as it is set: headrests are told from heads by it
Head find_head(const VehicleLayout& layout, const SeatPose& seat, const Scan& scan, const HeadOptions& options = {});

}  // namespace raybundle
