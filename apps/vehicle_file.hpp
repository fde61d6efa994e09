// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/occupancy/vehicle.hpp"
#include "raybundle/toml/toml_reader.hpp"

namespace raybundle::apps {

/// vehicle.toml. Include in .cpp files only: TOML is heavy.
class VehicleFile {
 public:
  /// @throws Error(kIo) when it cannot be read, Error(kBadInput) naming the line when it is no TOML
  explicit VehicleFile(const std::string& path);
  VehicleFile(const VehicleFile&) = delete;  // the reader refers to the table
  VehicleFile& operator=(const VehicleFile&) = delete;

  /// The section [vehicle], of which the seat's travel and the roof may be left out, and the sections [[fixture]].
  VehicleLayout layout();

  /// The section of a sensor.
  TomlReader section(const std::string& name);

 private:
  toml::table table_;
  TomlReader reader_;
};

/// A place [m] of a sensor's section, in the vehicle.
///
/// @throws Error(kBadInput) when it lies outside of any cabin
Eigen::Vector3d place_from(TomlReader& reader, const std::string& key);

/// rotation_xyzw and translation_m of a sensor's section: the pose of its frame in the vehicle.
Rigid3 pose_from(TomlReader& reader);

}  // namespace raybundle::apps
