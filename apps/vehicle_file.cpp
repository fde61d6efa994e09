// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "vehicle_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "raybundle/scene/csv.hpp"

namespace raybundle::apps {
namespace {

constexpr double kFarthest_m = 5.0;
constexpr double kMostRecline_rad = 1.75;  // 100 degrees: a seat that lies flat, and a little

// What decides about an airbag has to be a cabin.
void check(const VehicleLayout& layout, const TomlReader& reader) {
  const auto require = [&](bool good, const std::string& message) {
    if (!good) reader.fail(nullptr, message);
  };
  for (const double length_m :
       {layout.dashboard_x_m, layout.dashboard_top_m, layout.zone_floor_m, layout.zone_half_width_m,
        layout.out_of_position_m, layout.roof_m, layout.track_m, layout.lift_m}) {
    require(std::abs(length_m) <= kFarthest_m,
            fmt::format("[vehicle] holds {:g} m, and no cabin is so large; give metres", length_m));
  }
  require(
      layout.critical_m > 0.0 && layout.critical_m <= layout.out_of_position_m,
      fmt::format("[vehicle] critical_m = {:g} must be above 0 and at most out_of_position_m = {:g}: it is the front "
                  "part of that zone",
                  layout.critical_m, layout.out_of_position_m));
  require(layout.zone_half_width_m > 0.0, "[vehicle] zone_half_width_m must be above 0");
  require(layout.track_m >= 0.0 && layout.lift_m >= 0.0,
          "[vehicle] track_m and lift_m are lengths of travel and must not be below 0");
  require(layout.least_recline_rad <= layout.most_recline_rad,
          "[vehicle] least_recline_rad must not be above most_recline_rad");
  for (const double recline_rad : {layout.least_recline_rad, layout.most_recline_rad}) {
    require(
        std::abs(recline_rad) <= kMostRecline_rad,
        fmt::format("[vehicle] holds a recline of {:g} rad, and no back rest leans so far; give radians", recline_rad));
  }
  require(layout.roof_m > layout.zone_floor_m, "[vehicle] roof_m must be above zone_floor_m");
}

// Boxes [m] in the vehicle frame.
void read_fixtures(TomlReader& root, VehicleLayout& layout) {
  std::vector<TomlReader> sections = root.tables("fixture");
  const std::size_t most = layout.fixtures.size();
  if (sections.size() > most) sections[most].fail(nullptr, fmt::format("there are more than {} [[fixture]]", most));
  for (std::size_t i = 0; i < sections.size(); ++i) {
    TomlReader& section = sections[i];
    const Eigen::AlignedBox3d box{vector3(section, "low_m"), vector3(section, "high_m")};
    section.refuse_unknown_keys();
    if (box.isEmpty()) section.fail(nullptr, "[[fixture]] low_m must lie below high_m in x, y and z");
    if (!(box.min().x() >= layout.dashboard_x_m - layout.critical_m && box.sizes().maxCoeff() <= kFarthest_m)) {
      section.fail(nullptr, fmt::format("[[fixture]] reaches from x = {:g} m on, and what is not counted there may be "
                                        "somebody; it must not leave the critical zone, which begins at x = {:g} m",
                                        box.min().x(), layout.dashboard_x_m - layout.critical_m));
    }
    layout.fixtures[i] = box;
  }
}

}  // namespace

VehicleFile::VehicleFile(const std::string& path)
    : table_(toml_from_text(text_of_file(path), path)), reader_(table_, "the file", path) {
  for (const char* section : {"vehicle", "fixture", "sensor", "stereo"}) reader_.has(section);
  reader_.refuse_unknown_keys();
}

TomlReader VehicleFile::section(const std::string& name) {
  auto section = reader_.table(name, fmt::format("[{}]", name));
  if (!section) reader_.fail(nullptr, fmt::format("has no section [{}]; add it", name));
  return *section;
}

VehicleLayout VehicleFile::layout() {
  TomlReader reader = section("vehicle");
  VehicleLayout layout;
  for (const auto& [key, value] :
       {std::pair("dashboard_x_m", &layout.dashboard_x_m), std::pair("dashboard_top_m", &layout.dashboard_top_m),
        std::pair("zone_floor_m", &layout.zone_floor_m), std::pair("zone_half_width_m", &layout.zone_half_width_m),
        std::pair("critical_m", &layout.critical_m), std::pair("out_of_position_m", &layout.out_of_position_m)}) {
    *value = reader.number(key);
  }
  for (const auto& [key, value] :
       {std::pair("track_m", &layout.track_m), std::pair("lift_m", &layout.lift_m),
        std::pair("least_recline_rad", &layout.least_recline_rad),
        std::pair("most_recline_rad", &layout.most_recline_rad), std::pair("roof_m", &layout.roof_m)}) {
    *value = reader.number(key, *value);
  }
  reader.refuse_unknown_keys();
  check(layout, reader);
  read_fixtures(reader_, layout);
  return layout;
}

Eigen::Vector3d place_from(TomlReader& reader, const std::string& key) {
  const Eigen::Vector3d place = vector3(reader, key);
  if (!(place.norm() <= kFarthest_m)) {
    reader.fail(nullptr, fmt::format("{} is {:g} m long, and no cabin is so large; give metres", key, place.norm()));
  }
  return place;
}

Rigid3 pose_from(TomlReader& reader) {
  const std::vector<double> q = reader.numbers("rotation_xyzw", 4);
  Rigid3 pose{Eigen::Quaterniond(q[3], q[0], q[1], q[2]), place_from(reader, "translation_m")};
  if (std::abs(pose.rotation.norm() - 1.0) > 1e-6) {
    reader.fail(nullptr, "rotation_xyzw has no unit length; give six digits and more");
  }
  pose.rotation.normalize();
  return pose;
}

}  // namespace raybundle::apps
