// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle::apps {

/// What vehicle.toml says: docs/formats/occupancy.md.
struct InstalledSensor {
  VehicleLayout layout;
  Rigid3 vehicle_from_camera;
  Eigen::Vector3d viewpoint_in_vehicle = Eigen::Vector3d::Zero();  ///< [m] where the beams leave
  int rows = 0, columns = 0;                                       ///< of beams

  int rays() const { return rows * columns; }
};

/// @throws Error(kIo) when it cannot be read; Error(kBadInput) naming file and key
InstalledSensor read_installed_sensor(const std::string& path);

/// One frame.
struct PointFrame {
  std::vector<ScenePoint> points;
  State state = State::kOk;
};

/// Points of `reconstruct structured-light` in the vehicle.
///
/// @throws Error as read_installed_sensor
PointFrame read_point_frame(const std::string& path, const InstalledSensor& sensor);

}  // namespace raybundle::apps
