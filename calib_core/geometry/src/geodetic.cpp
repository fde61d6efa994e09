// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/geodetic.hpp"

#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>
#include <string>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

void check(const Geodetic& place) {
  if (std::abs(place.latitude_deg) <= 90.0 && std::isfinite(place.longitude_deg) && std::isfinite(place.height_m)) {
    return;
  }
  throw Error(ErrorKind::kBadInput, "latitude " + std::to_string(place.latitude_deg) + ", longitude " +
                                        std::to_string(place.longitude_deg) + ", height " +
                                        std::to_string(place.height_m) +
                                        " is no place: degrees, latitude first and within ±90, then metres");
}

}  // namespace

Eigen::Vector3d enu_from_geodetic(const Geodetic& origin, const Geodetic& place) {
  check(origin);
  check(place);
  const GeographicLib::LocalCartesian frame(origin.latitude_deg, origin.longitude_deg, origin.height_m);
  Eigen::Vector3d x;
  frame.Forward(place.latitude_deg, place.longitude_deg, place.height_m, x.x(), x.y(), x.z());
  return x;
}

Geodetic geodetic_from_enu(const Geodetic& origin, const Eigen::Vector3d& x_in_enu) {
  check(origin);
  const GeographicLib::LocalCartesian frame(origin.latitude_deg, origin.longitude_deg, origin.height_m);
  Geodetic place;
  frame.Reverse(x_in_enu.x(), x_in_enu.y(), x_in_enu.z(), place.latitude_deg, place.longitude_deg, place.height_m);
  return place;
}

Eigen::Vector3d enu_from_azimuth(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::sin(azimuth_rad), std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::sin(elevation_rad)};
}

}  // namespace raybundle
