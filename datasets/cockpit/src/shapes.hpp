// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <utility>
#include <vector>

#include "raybundle/cockpit/cockpit.hpp"

namespace raybundle {

using Polyline = std::vector<Eigen::Vector2d>;

/// A surface over a grid of u and v in [0, 1]; its places are its vertices.
CabinMesh grid_mesh(int columns, int rows, const std::function<Eigen::Vector3d(double, double)>& at);

/// A cone with half balls on its ends, from the origin along z.
CabinMesh round_cone(double length_m, double radius_m, double end_radius_m);

/// A box with round edges around the origin. Source: Barr 1981, superquadrics.
///
/// @param roundness   1: an ellipsoid; towards 0: a box
/// @param longitudes  of the mesh, even
CabinMesh rounded_box(const Eigen::Vector3d& semi_axes_m, double roundness, int longitudes = 28);

inline CabinMesh ellipsoid(const Eigen::Vector3d& semi_axes_m, int longitudes = 28) {
  return rounded_box(semi_axes_m, 1.0, longitudes);
}

/// A line of x and z, swept along y.
CabinMesh swept(const Polyline& line_xz, double y_from, double y_to);

/// The mesh as a part of the cabin.
CabinMesh placed(CabinMesh mesh, const Rigid3& vehicle_from_body, CabinPart part, const CabinMaterial& material);

/// A round cone between two places of the vehicle frame.
CabinMesh limb(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_m, double end_radius_m,
               CabinPart part, const CabinMaterial& material);

/// Rotation about an axis of the vehicle frame.
inline Eigen::Quaterniond about_x(double angle_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitX()));
}
inline Eigen::Quaterniond about_y(double angle_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()));
}
inline Eigen::Quaterniond about_z(double angle_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()));
}

}  // namespace raybundle
