// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/beam_geometry.hpp"

#include <Eigen/Geometry>

namespace raybundle {

BeamGeometry beam_geometry(const TableBeam& beam, double log_wavelength) {
  BeamGeometry geometry;
  const Line3 line = log_wavelength == 0.0 ? beam.line : perturbed(beam.line, log_wavelength * beam.per_wavelength);
  geometry.point = line.point;
  geometry.direction = line.direction;
  geometry.normal = line.point.cross(line.direction).normalized();
  geometry.across = geometry.normal.cross(line.direction);
  geometry.distance_m = line.point.dot(geometry.across);
  // p = (p·u) u + (p·across) across in the plane, and p × u = (p·across) across × u = (p·across) normal, up to the sign
  // of normal's definition: distance is |p × u|.
  if (geometry.distance_m < 0.0) {
    geometry.across = -geometry.across;
    geometry.distance_m = -geometry.distance_m;
  }
  const Eigen::Vector2d n = across(line.direction).transpose() * geometry.normal;
  const Eigen::Matrix4d& c = beam.covariance;
  geometry.variance << n.dot(c.topLeftCorner<2, 2>() * n), n.dot(c.topRightCorner<2, 2>() * n),
      n.dot(c.bottomRightCorner<2, 2>() * n);
  geometry.wavelength << n.dot(beam.per_wavelength.head<2>()), n.dot(beam.per_wavelength.tail<2>());
  return geometry;
}

}  // namespace raybundle
