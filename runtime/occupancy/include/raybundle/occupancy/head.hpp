// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/seat.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

/// What heads are like, and what is believed to be one. Sizes follow ISO 7250: adults of both sexes and schoolchildren;
/// toddlers' where heads are low.
struct HeadOptions {
  Eigen::Vector3d semi_axes_m = {0.093, 0.074, 0.108};  ///< to the face, to the ear, to the crown
  Eigen::Vector3d growth = {0.75, 0.90, 1.35};  ///< of their logarithms by that of the size: children's faces are short
  double size_sigma = 0.06;                     ///< of the size's logarithm
  /// The height of who sits tells the size: of heads that are nearer to the bight than this, the common size's logarithm
  /// falls by so much a metre, down to that of toddlers. Who leans turns about the hips, and stays as far from the bight.
  double small_below_m = 0.72, shrink_per_m = 0.9, least_log_size = -0.11;
  double turn_sigma_rad = 0.7;  ///< of heads about the vertical, against looking ahead
  double nod_rad = 0.15;        ///< commonly, the face down
  double nod_sigma_rad = 0.4;
  /// The head's centre from that of head and hair together, in the axes of the head: hair lies on its back and crown.
  Eigen::Vector3d centre_from_hair_m = {0.004, 0.0, -0.003};
  double hair_sigma_m = 0.006;   ///< of the centre: how hair lies is not known
  double shape_sigma_m = 0.006;  ///< of faces and hair from the ellipsoid
  double curved_sigmas = 1.0;    ///< depths scatter on heads by so many sigmas, none taken above the surest quarter's
  double alike_m = 0.03;         ///< places on a head that are so near err alike: a matcher's window, a lock of hair
  double least_above_bight_m = 0.40;  ///< of the centre; lower are knees, fists and bags

  /// Over the front half of the cushion, so far before the bight, heads of this height are not told: there lie those of
  /// babies that face the rear, and what the shells of their seats leave to be seen does not tell where they are. A
  /// head on the dashboard is farther ahead.
  double least_above_front_m = 0.60;
  double front_from_m = 0.33, front_to_m = 0.62;
  double least_before_back_m = 0.10;  ///< half a head's length: headrests are nearer
  double least_from_side_m = 0.06;    ///< of its centre, from the zones' sides: it is over the seat
  int least_points = 60;
  double least_filled = 0.60;  ///< more than half of a head is seen, not a rim of it
  double least_clear = 0.35;   ///< a shoulder and a headrest may stand beside it, but no wall all around
  /// 1: points lie about the ellipsoid as their sigmas say; knees, bags and the shells of baby seats do not. Of some
  /// thirty places on a head that err apart, it scatters by 0.13.
  double most_misfit = 1.05;
  /// Faces, hair and the matcher let surfaces of heads bend so much more or less than the ellipsoid, of nineteen in
  /// twenty at most 0.3; what is beyond counts as misfit, as the root of the sum of squares.
  double common_bend_off = 0.25;
  double most_pierced = 0.08;  ///< heads are opaque: of a hundred heads, one has 0.04, at smeared rims
};

/// A head that was found.
struct Head {
  bool found = false;
  Eigen::Vector3d front = Eigen::Vector3d::Zero();  ///< [m] where the line from the sensor to the centre enters it
  Eigen::Matrix3d front_covariance_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();         ///< [m] of the head's ellipsoid, in the vehicle frame
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of the centre
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Zero();    ///< to the face, to the ear, to the crown
  double size = 1.0;                                        ///< the mean head has 1
  Eigen::Matrix3d vehicle_from_head = Eigen::Matrix3d::Identity();  ///< columns: towards face, left ear, crown
  int points = 0;                                                   ///< on it
  double misfit = 0.0;  ///< their root mean square distance from it, in sigmas of points and of shape
  /// How much less, or more, the surface that is seen bends than the ellipsoid, in the direction in which it does so
  /// most; 0: as much, 1: not at all, as plates do, and tubes along their length.
  double bend_off = 0.0;
  double pierced = 0.0;  ///< share of the rays through the ellipsoid that end far behind it
  double filled = 0.0;   ///< share of the rays through a ball of its size that end on it
  double clear = 0.0;    ///< share of the rays just beside the upper half of that ball that end far behind
};

/// The head of whoever is on the seat, from the dense points of one frame.
///
/// Where points are as if on the front of a ball that stands free, an ellipsoid of the size of heads is fitted: points
/// on it pull its surface, rays that pass beside it push it. Told are its front, the middle of the surface that the
/// sensor sees, and its centre, a point amid the head: the front is measured, the centre lies behind it by a size that
/// one view hardly shows, and is less sure by that. What is no head in shape, in place above the seat, or in how it
/// stands free, lets rays through, or bends otherwise, is not found; of several, as hands and knees may be, it is the
/// highest. Without heap; the same bits on every run.
///
/// @param seat  as it is set: headrests are told from heads by it
Head find_head(const VehicleLayout& layout, const SeatPose& seat, const Scan& scan, const HeadOptions& options = {});

}  // namespace raybundle
