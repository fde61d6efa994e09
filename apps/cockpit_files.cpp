// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "cockpit_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <vector>

#include "pose_json.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

ordered_json numbers(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

// Lines of TOML, which writes numbers and lists of them as JSON does.
std::string toml_of(const ordered_json& object) {
  std::string text;
  for (const auto& [key, value] : object.items()) text += fmt::format("{} = {}\n", key, value.dump());
  return text;
}

std::string toml_of(const std::vector<Eigen::AlignedBox3d>& fixtures) {
  std::string text;
  for (const Eigen::AlignedBox3d& fixture : fixtures) {
    text +=
        "[[fixture]]\n" + toml_of(ordered_json{{"low_m", numbers(fixture.min())}, {"high_m", numbers(fixture.max())}});
  }
  return text;
}

}  // namespace

ordered_json json_from_layout(const CabinLayout& layout) {
  return {{"dashboard_x_m", layout.dashboard_x_m},
          {"dashboard_top_m", layout.dashboard_top_m},
          {"zone_floor_m", layout.zone_floor_m},
          {"zone_half_width_m", layout.zone_half_width_m},
          {"critical_m", layout.critical_m},
          {"out_of_position_m", layout.out_of_position_m},
          {"track_m", layout.track_m},
          {"lift_m", layout.lift_m},
          {"least_recline_rad", layout.least_recline_rad},
          {"most_recline_rad", layout.most_recline_rad},
          {"roof_m", layout.roof_m}};
}

ordered_json json_from_truth(const CockpitTruth& truth) {
  const auto named = [](const auto& names, auto value) { return std::string(names[static_cast<std::size_t>(value)]); };
  ordered_json json{{"class", named(kCabinClassNames, truth.seat_class)},
                    {"group", named(kCabinGroupNames, truth.group)},
                    {"decision", named(kCabinDecisionNames, truth.decision)},
                    {"seat",
                     {{"h_point_m", numbers(truth.seat.h_point)},
                      {"bight_m", numbers(truth.seat.bight)},
                      {"recline_rad", truth.seat.recline_rad},
                      {"cushion_pitch_rad", truth.seat.cushion_pitch_rad}}}};
  if (truth.head)
    json["head"] = {{"centre_m", numbers(truth.head->centre)}, {"semi_axes_m", numbers(truth.head->semi_axes)}};
  if (std::isfinite(truth.dashboard_distance_m)) json["dashboard_distance_m"] = truth.dashboard_distance_m;
  return json;
}

std::string vehicle_toml(const CabinLayout& layout, const CabinSensor& sensor) {
  const Rigid3& known = sensor.known_vehicle_from_rig;
  const std::string vehicle = "[vehicle]\n" + toml_of(json_from_layout(layout));
  const std::string fixtures = toml_of(layout.fixtures);
  if (!sensor.rig.emitter) return vehicle + "[stereo]\n" + toml_of(json_from_pose(known)) + fixtures;
  const Emitter& emitter = *sensor.rig.emitter;
  ordered_json section{{"rows", emitter.grid.rows}, {"columns", emitter.grid.columns}};
  section.update(json_from_pose(known * sensor.rig.cameras.front().camera_from_rig.inverse()));
  section["viewpoint_m"] = numbers(known * emitter.rig_from_emitter.translation);
  return vehicle + "[sensor]\n" + toml_of(section) + fixtures;
}

std::string cockpit_frame_name(int scene, int frame) { return fmt::format("{:05d}_{:03d}", scene, frame); }

std::string vehicle_file_name(int scene) { return fmt::format("{:05d}_vehicle.toml", scene); }

void remove_former_files(const fs::path& folder, const ordered_json& scenes) {
  static const std::regex kOurs(R"(\d{5}_(vehicle\.toml|\d{3}_(off|on|left|right)\.png))");
  std::set<std::string> written;
  for (const auto& scene : scenes) {
    written.insert(scene.at("vehicle_file"));
    for (const auto& frame : scene.at("frames")) {
      for (const auto& name : frame.at("images")) written.insert(name);
    }
  }
  std::vector<fs::path> former;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (std::regex_match(name, kOurs) && !written.contains(name)) former.push_back(entry.path());
  }
  for (const fs::path& path : former) fs::remove(path);
  if (!former.empty()) say(fmt::format("removed {} files of a former run from {}", former.size(), folder.string()));
}

}  // namespace raybundle::apps
