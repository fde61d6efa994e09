// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "raybundle/structured_light/sensor_table.hpp"

namespace raybundle {

/// A beam as the camera's centre sees it: the epipolar plane of camera and beam, and how far along a ray the beam is.
/// No lens model and no undistortion are needed: rays are compared with planes.
struct BeamGeometry {
  Eigen::Vector3d point;      ///< of the line
  Eigen::Vector3d direction;  ///< unit
  Eigen::Vector3d normal;     ///< unit, of the epipolar plane: p × u / |p × u|
  Eigen::Vector3d across;     ///< unit, in that plane, at right angles to the beam
  double distance_m = 0.0;    ///< of the beam from the camera's centre, along `across`; never negative

  // Along `normal`, the line's place at `along` has variance v[0] + 2 along v[1] + along² v[2], and moves by
  // (wavelength[0] + along wavelength[1]) for each unit of ln(wavelength).
  Eigen::Vector3d variance;
  Eigen::Vector2d wavelength;

  /// Sine of the angle between a unit ray and the epipolar plane.
  double off_plane(const Eigen::Vector3d& ray) const { return ray.dot(normal); }

  /// Inverse distance [1/m] from the camera's centre of the beam's point that is nearest to the ray in angle; negative
  /// behind the camera.
  double inverse_distance(const Eigen::Vector3d& ray) const { return ray.dot(across) / distance_m; }

  /// Place on the beam of a point of its plane, measured from `point` [m].
  double along(const Eigen::Vector3d& x) const { return (x - point).dot(direction); }

  /// Of off_plane() by the beam's own uncertainty, at a place and a distance from the camera.
  double off_plane_variance(double along_m, double inverse_distance) const {
    return (variance[0] + along_m * (2.0 * variance[1] + along_m * variance[2])) * inverse_distance * inverse_distance;
  }

  /// Change of off_plane() for each unit of ln(wavelength).
  double off_plane_by_wavelength(double along_m, double inverse_distance) const {
    return (wavelength[0] + along_m * wavelength[1]) * inverse_distance;
  }
};

/// @param log_wavelength  ln of the wavelength over that of the calibration
BeamGeometry beam_geometry(const TableBeam& beam, double log_wavelength = 0.0);

/// The dot of a beam on a ray.
struct BeamPoint {
  Eigen::Vector3d x;              ///< on the beam, in the camera's frame [m]
  Eigen::Vector3d ray;            ///< unit, from the camera's centre to x
  double inverse_distance = 0.0;  ///< [1/m]
  double along_m = 0.0;           ///< place on the beam
};

/// The beam's point that is nearest to the ray in angle; inverse_distance must be positive.
inline BeamPoint beam_point(const BeamGeometry& beam, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d in_plane = ray - beam.off_plane(ray) * beam.normal;
  BeamPoint point;
  const double range = beam.distance_m / ray.dot(beam.across);
  point.x = range * in_plane;
  point.inverse_distance = 1.0 / point.x.norm();
  point.ray = point.x * point.inverse_distance;
  point.along_m = beam.along(point.x);
  return point;
}

}  // namespace raybundle
