// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_frame_files.hpp"

#include <nlohmann/json.hpp>

#include "image_codec.hpp"
#include "laser_page.hpp"
#include "mesh_files.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "state_name.hpp"

namespace raybundle::apps {
namespace {

using Json = nlohmann::ordered_json;

template <typename Vector>
Json list(const Vector& vector) {
  Json values = Json::array();
  for (const double number : vector.reshaped()) values.push_back(number);
  return values;
}

Json json_of(const HealthReport& health) {
  return {{"state", state_name(health.state)},
          {"log_wavelength", health.log_wavelength},
          {"log_wavelength_sigma", health.log_wavelength_sigma},
          {"turn_rad", list(health.turn_rad)},
          {"turn_sigma_rad", list(health.turn_sigma_rad)},
          {"chi_squared", health.chi_squared},
          {"recent_turn_rad", list(health.recent_turn_rad)},
          {"recent_chi_squared", health.recent_chi_squared},
          {"alarm_above", health.threshold},
          {"noise", health.residual_scale},
          {"dots", health.dots}};
}

Json json_of(const LaserFrame& frame, const SensorTable& table, const std::string& image) {
  Json dots = Json::array(), points = Json::array(), triangles = Json::array();
  for (const Dot& dot : frame.dots) {
    Json one{{"pixel", list(dot.pixel)}, {"covariance_px2", list(dot.covariance_px2)}, {"brightness", dot.brightness}};
    one["row"] = dot.beam == kUnlabelled ? Json() : Json(table.grid.row(dot.beam));
    one["column"] = dot.beam == kUnlabelled ? Json() : Json(table.grid.column(dot.beam));
    dots.push_back(one);
  }
  for (const LaserPoint& point : frame.points) {
    const TableBeam& beam = table.beams[point.beam];
    points.push_back({{"row", beam.row},
                      {"column", beam.column},
                      {"dot", point.dot},
                      {"x_in_camera_m", list(point.x_in_camera)},
                      {"covariance_m2", list(point.covariance)},
                      {"off_sigmas", point.off_sigmas}});
  }
  for (const Triangle& triangle : frame.mesh) triangles.push_back({triangle.a, triangle.b, triangle.c});
  return {{"format", "raybundle laser points"},
          {"version", 1},
          {"image", image},
          {"camera", table.camera},
          {"serial", table.serial.empty() ? Json() : Json(table.serial)},
          {"state", state_name(frame.state)},
          {"rows", table.grid.rows},
          {"columns", table.grid.columns},
          {"dots", dots},
          {"points", points},
          {"triangles", triangles},
          {"health", json_of(frame.health)}};
}

PointMesh mesh_of(const LaserFrame& frame, const SensorTable& table) {
  PointMesh mesh{.points = {}, .triangles = {}, .names = {"row", "column", "sigma_z_m"}, .numbers = {{}, {}, {}}};
  for (const LaserPoint& point : frame.points) {
    mesh.points.push_back(point.x_in_camera);
    mesh.numbers[0].push_back(table.beams[point.beam].row);
    mesh.numbers[1].push_back(table.beams[point.beam].column);
    mesh.numbers[2].push_back(std::sqrt(point.covariance(2, 2)));
  }
  for (const Triangle& triangle : frame.mesh) mesh.triangles.push_back({triangle.a, triangle.b, triangle.c});
  return mesh;
}

}  // namespace

LaserFrameFiles laser_frame_files(const LaserFrame& frame, const SensorTable& table, const std::string& image,
                                  const cv::Mat& grey) {
  const Json json = json_of(frame, table, image);
  const PointMesh mesh = mesh_of(frame, table);
  return {text_of_json(json, 1), ply_from(mesh), glb_from(mesh), laser_page(text_of_json(json), jpeg_from(grey))};
}

}  // namespace raybundle::apps
