// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_input.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "points_json.hpp"
#include "raybundle/geometry/error.hpp"
#include "state_name.hpp"
#include "vehicle_file.hpp"

namespace raybundle::apps {
namespace {

// A row or column; -1 for what is no whole number, which a conversion would cut to one.
int place_in_grid(const nlohmann::json& value) { return value.is_number_integer() ? value.get<int>() : -1; }

}  // namespace

InstalledSensor read_installed_sensor(const std::string& path) {
  VehicleFile file(path);
  InstalledSensor sensor;
  sensor.layout = file.layout();
  TomlReader section = file.section("sensor");
  sensor.rows = section.whole("rows", 2, 64);
  sensor.columns = section.whole("columns", 2, 64);
  sensor.vehicle_from_camera = pose_from(section);
  sensor.viewpoint_in_vehicle = place_from(section, "viewpoint_m");
  section.refuse_unknown_keys();
  return sensor;
}

PointFrame read_point_frame(const std::string& path, const InstalledSensor& sensor) {
  PointFrame frame;
  read_points_json(path, kLaserPoints, [&](const nlohmann::json& json) {
    frame.state = state_named(json.at("state").get<std::string>());
    if (json.at("rows") != sensor.rows || json.at("columns") != sensor.columns) {
      throw Error(ErrorKind::kBadInput,
                  fmt::format("is of a laser of {} rows and {} columns; vehicle.toml says {} and {}",
                              json.at("rows").get<int>(), json.at("columns").get<int>(), sensor.rows, sensor.columns),
                  path);
    }
    std::vector<char> taken(static_cast<std::size_t>(sensor.rays()), 0);
    for (const auto& point : json.at("points")) {
      const int row = place_in_grid(point.at("row")), column = place_in_grid(point.at("column"));
      if (row < 0 || row >= sensor.rows || column < 0 || column >= sensor.columns ||
          taken[row * sensor.columns + column]++ > 0) {
        throw Error(
            ErrorKind::kBadInput,
            fmt::format("row {}, column {} is outside of the grid, or stands there twice; make it again", row, column),
            path);
      }
      const std::array<double, 3> x = point.at("x_in_camera_m");
      const std::array<double, 9> covariance = point.at("covariance_m2");
      if (!(std::hypot(x[0], x[1], x[2]) < kFarthestPoint_m)) {
        throw Error(ErrorKind::kBadInput,
                    fmt::format("row {}, column {} lies beyond {:g} m; make it again", row, column, kFarthestPoint_m),
                    path);
      }
      for (const double variance : {covariance[0], covariance[4], covariance[8]}) {
        if (variance >= 0.0) continue;
        throw Error(ErrorKind::kBadInput,
                    fmt::format("row {}, column {} has a negative variance; make it again", row, column), path);
      }
      frame.points.push_back({row * sensor.columns + column, sensor.vehicle_from_camera * Eigen::Vector3d(x.data()),
                              std::sqrt(covariance[0] + covariance[4] + covariance[8])});
    }
  });
  return frame;
}

}  // namespace raybundle::apps
