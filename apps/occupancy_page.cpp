// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_page.hpp"

#include <nlohmann/json.hpp>

#include "page_parts.hpp"
#include "page_text.hpp"

namespace raybundle::apps {
namespace {

nlohmann::ordered_json json_of(const VehicleLayout& layout) {
  return {{"dashboard_x_m", layout.dashboard_x_m},
          {"zone_floor_m", layout.zone_floor_m},
          {"zone_half_width_m", layout.zone_half_width_m},
          {"critical_m", layout.critical_m},
          {"out_of_position_m", layout.out_of_position_m}};
}

}  // namespace

std::string occupancy_page(const VehicleLayout& layout, const nlohmann::ordered_json& frames) {
  const nlohmann::ordered_json data{{"vehicle", json_of(layout)}, {"frames", frames}};
  return filled(kOccupancyPage, "data", json_for_script(text_of_json(data)));
}

nlohmann::ordered_json page_points(const std::vector<ScenePoint>& points) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const ScenePoint& point : points) {
    const Eigen::Vector3d& x = point.x_in_vehicle;
    json.push_back({{"ray", point.ray}, {"x_in_vehicle_m", {x.x(), x.y(), x.z()}}, {"sigma_m", point.sigma_m}});
  }
  return json;
}

}  // namespace raybundle::apps
