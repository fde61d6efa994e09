// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_input.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "vehicle_file.hpp"

namespace raybundle::apps {
namespace {

State state_of(const std::string& word) {
  return word == "OK" ? State::kOk : word == "DEGRADED" ? State::kDegraded : State::kInvalid;
}

}  // namespace

InstalledSensor read_installed_sensor(const std::string& path) {
  const toml::table file = vehicle_file(path);
  InstalledSensor sensor;
  sensor.layout = vehicle_layout_in(file, path);
  VehicleSection section(file, "sensor", path);
  sensor.rows = static_cast<int>(section.number("rows"));
  sensor.columns = static_cast<int>(section.number("columns"));
  if (sensor.rows < 2 || sensor.columns < 2 || sensor.rows > 64 || sensor.columns > 64) {
    throw Error(ErrorKind::kBadInput, "[sensor] rows and columns count the beams of the laser, 2 to 64 each", path);
  }
  sensor.vehicle_from_camera = section.pose();
  sensor.viewpoint_in_vehicle = Eigen::Vector3d(section.numbers<3>("viewpoint_m").data());
  section.expect_no_more();
  return sensor;
}

PointFrame read_point_frame(const std::string& path, const InstalledSensor& sensor) {
  PointFrame frame;
  try {
    const auto json = nlohmann::json::parse(text_of_file(path));
    if (json.at("format") != "raybundle laser points" || json.at("version") != 1) {
      throw Error(ErrorKind::kBadInput, "is not what `raybundle reconstruct structured-light` writes", path);
    }
    frame.state = state_of(json.at("state"));
    std::vector<char> taken(static_cast<std::size_t>(sensor.rays()), 0);
    for (const auto& point : json.at("points")) {
      const int row = point.at("row"), column = point.at("column");
      if (row < 0 || row >= sensor.rows || column < 0 || column >= sensor.columns ||
          taken[row * sensor.columns + column]++ > 0) {
        throw Error(
            ErrorKind::kBadInput,
            fmt::format("row {}, column {} is outside of the grid of vehicle.toml, or stands there twice", row, column),
            path);
      }
      const std::array<double, 3> x = point.at("x_in_camera_m");
      const std::array<double, 9> covariance = point.at("covariance_m2");
      frame.points.push_back({row * sensor.columns + column, sensor.vehicle_from_camera * Eigen::Vector3d(x.data()),
                              std::sqrt(covariance[0] + covariance[4] + covariance[8])});
    }
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorKind::kBadInput, fmt::format("is damaged: {}; make it again", error.what()), path);
  }
  return frame;
}

}  // namespace raybundle::apps
