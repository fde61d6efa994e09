// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace raybundle {

/// A place on the Earth, on the WGS84 ellipsoid.
struct Geodetic {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double height_m = 0.0;  ///< above the ellipsoid, not above the sea: the geoid lies up to 100 m from it
};

/// East, north, up [m] from an origin: a Cartesian frame, in which a place 5 km away at the same height lies 2 m below.
///
/// @throws Error(kBadInput) for latitudes beyond ±90° and numbers that are not finite
Eigen::Vector3d enu_from_geodetic(const Geodetic& origin, const Geodetic& place);

/// The place at an east, north, up of an origin.
Geodetic geodetic_from_enu(const Geodetic& origin, const Eigen::Vector3d& x_in_enu);

/// Unit vector in east, north, up.
///
/// @param azimuth_rad    from north, clockwise
/// @param elevation_rad  above the horizon
Eigen::Vector3d enu_from_azimuth(double azimuth_rad, double elevation_rad);

}  // namespace raybundle
