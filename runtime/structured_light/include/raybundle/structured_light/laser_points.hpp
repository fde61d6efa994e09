// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "raybundle/structured_light/labels.hpp"

namespace raybundle {

/// A place where a beam hits the scene.
struct LaserPoint {
  int dot = 0;                                            ///< of the image
  int beam = 0;                                           ///< index into SensorTable::beams
  Eigen::Vector3d x_in_camera = Eigen::Vector3d::Zero();  ///< on the beam [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m²], of the dot's place in the image, beam and wavelength
  double off_sigmas = 0.0;  ///< of the dot from the beam's curve: the equation that the depth does not use up
};

/// The point of a beam that is nearest in angle to the ray of a dot, and its covariance: the dot moves it along the
/// beam, the beam's own uncertainty moves it along the ray and with the beam, and so does that of the wavelength, by
/// which all points of an image err together.
LaserPoint laser_point(const TableBeam& beam, const BeamGeometry& geometry, const RayTable::Ray& ray,
                       const Eigen::Matrix2d& covariance_px2, double log_wavelength_variance = 0.0);

/// Three points by their indices, seen counter-clockwise by the camera.
struct Triangle {
  int a = 0, b = 0, c = 0;
};

/// Triangles between points of neighbouring beams. None spans a jump: no side is longer than `most_slant` times what it
/// would be on a surface that faces the camera.
///
/// @param point_of_beam  index into points, or -1
/// @param triangles      replaced; at most two for each beam
void mesh(const BeamLattice& lattice, std::span<const LaserPoint> points, std::span<const int> point_of_beam,
          double most_slant, std::vector<Triangle>& triangles);

}  // namespace raybundle
