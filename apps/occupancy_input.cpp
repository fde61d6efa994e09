// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_input.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

std::string text_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file) throw Error(ErrorKind::kIo, "cannot be read; check the name", path);
  return text;
}

toml::table table_of(const std::string& path) {
  try {
    return toml::parse(text_of_file(path), path);
  } catch (const toml::parse_error& error) {
    throw Error(ErrorKind::kBadInput, fmt::format("is not TOML: {}", error.description()),
                fmt::format("{}:{}", path, error.source().begin.line));
  }
}

// A section all of whose keys must be known.
class Section {
 public:
  Section(const toml::table& file, const char* name, const std::string& path) : name_(name), path_(path) {
    const toml::table* table = file[name].as_table();
    if (table == nullptr) throw Error(ErrorKind::kBadInput, fmt::format("has no section [{}]; add it", name), path);
    left_ = *table;
  }

  double number(const char* key) {
    const auto value = left_[key].value<double>();
    if (!value || !std::isfinite(*value)) fail(key, "a number");
    left_.erase(key);
    return *value;
  }

  template <std::size_t kSize>
  std::array<double, kSize> numbers(const char* key) {
    std::array<double, kSize> values{};
    const toml::array* array = left_[key].as_array();
    if (array == nullptr || array->size() != kSize) fail(key, fmt::format("a list of {} numbers", kSize));
    for (std::size_t i = 0; i < kSize; ++i) {
      const auto value = array->get(i)->value<double>();
      if (!value || !std::isfinite(*value)) fail(key, fmt::format("a list of {} numbers", kSize));
      values[i] = *value;
    }
    left_.erase(key);
    return values;
  }

  void expect_no_more() const {
    if (left_.empty()) return;
    throw Error(ErrorKind::kBadInput,
                fmt::format("[{}] has an unknown key '{}'; remove it", name_, left_.begin()->first.str()), path_);
  }

 private:
  [[noreturn]] void fail(const char* key, const std::string& wanted) const {
    throw Error(ErrorKind::kBadInput, fmt::format("[{}] needs {} = {}", name_, key, wanted), path_);
  }

  std::string name_, path_;
  toml::table left_;
};

VehicleLayout layout_of(Section section) {
  VehicleLayout layout;
  const std::pair<const char*, double*> keys[] = {
      {"dashboard_x_m", &layout.dashboard_x_m}, {"dashboard_top_m", &layout.dashboard_top_m},
      {"zone_floor_m", &layout.zone_floor_m},   {"zone_half_width_m", &layout.zone_half_width_m},
      {"critical_m", &layout.critical_m},       {"out_of_position_m", &layout.out_of_position_m}};
  for (const auto& [key, value] : keys) *value = section.number(key);
  section.expect_no_more();
  return layout;
}

State state_of(const std::string& word) {
  return word == "OK" ? State::kOk : word == "DEGRADED" ? State::kDegraded : State::kInvalid;
}

}  // namespace

InstalledSensor read_installed_sensor(const std::string& path) {
  const toml::table file = table_of(path);
  InstalledSensor sensor;
  sensor.layout = layout_of({file, "vehicle", path});
  Section section(file, "sensor", path);
  sensor.rows = static_cast<int>(section.number("rows"));
  sensor.columns = static_cast<int>(section.number("columns"));
  if (sensor.rows < 2 || sensor.columns < 2 || sensor.rows > 64 || sensor.columns > 64) {
    throw Error(ErrorKind::kBadInput, "[sensor] rows and columns count the beams of the laser, 2 to 64 each", path);
  }
  const auto q = section.numbers<4>("rotation_xyzw");
  sensor.vehicle_from_camera.rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
  if (std::abs(sensor.vehicle_from_camera.rotation.norm() - 1.0) > 1e-6) {
    throw Error(ErrorKind::kBadInput, "[sensor] rotation_xyzw has no unit length; give six digits and more", path);
  }
  sensor.vehicle_from_camera.rotation.normalize();
  sensor.vehicle_from_camera.translation = Eigen::Vector3d(section.numbers<3>("translation_m").data());
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
