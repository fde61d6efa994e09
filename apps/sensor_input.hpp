// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/structured_light/table_file.hpp"

namespace raybundle::apps {

/// How a calibration becomes a structured-light sensor.
struct SensorFlags {
  std::string camera;  ///< empty: the first one
  double nearest_m = SensorRange{}.nearest_m;
  double farthest_m = SensorRange{}.farthest_m;
  std::optional<double> tolerance_px;      ///< the calibration's advice unless said, else that of SensorRange
  std::vector<CLI::Option*> options = {};  ///< by which the last three are said
};

/// --nearest, --farthest, --tolerance.
void declare_sensor_flags(CLI::App& verb, SensorFlags& flags);

/// The table of a calibration.
///
/// @param path  calibration.json
SensorTable table_from_calibration(const std::string& path, const SensorFlags& flags);

/// The same, or the table in a file that is one already, which takes no --nearest, --farthest or --tolerance.
///
/// @throws Error(kBadInput) when one was said
SensorTable sensor_of(const std::string& path, const SensorFlags& flags);

}  // namespace raybundle::apps
