// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "raybundle/device/image_view.hpp"
#include "raybundle/structured_light/table_file.hpp"

namespace raybundle::apps {

/// How a calibration becomes a structured-light sensor.
struct SensorFlags {
  std::string camera;  ///< empty: the first one
  double nearest_m = SensorRange{}.nearest_m;
  double farthest_m = SensorRange{}.farthest_m;
  std::optional<double> tolerance_px;  ///< the calibration's advice unless said, else that of SensorRange
};

/// --nearest, --farthest, --tolerance.
void declare_sensor_flags(CLI::App& verb, SensorFlags& flags);

/// The table of a calibration.
///
/// @param path  calibration.json
SensorTable table_from_calibration(const std::string& path, const SensorFlags& flags);

/// The same, or the table in a file that is one already.
SensorTable sensor_of(const std::string& path, const SensorFlags& flags);

/// A grey image of 8 bits; deeper ones are scaled from the range that they use: 10, 12 or 16 bits.
///
/// @throws Error(kIo) when it cannot be read; Error(kBadInput) when it is not of the sensor's size
cv::Mat sensor_image(const std::string& path, const SensorTable& table);

/// A view of it.
GreyView view_of(const cv::Mat& image);

}  // namespace raybundle::apps
