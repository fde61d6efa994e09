// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "vehicle_file.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle::apps {
namespace {

constexpr double kFarthest_m = 5.0;
constexpr double kMostRecline_rad = 1.75;  // 100 degrees: a seat that lies flat, and a little

// What decides about an airbag has to be a cabin.
void check(const VehicleLayout& layout, const std::string& path) {
  for (const double length_m :
       {layout.dashboard_x_m, layout.dashboard_top_m, layout.zone_floor_m, layout.zone_half_width_m,
        layout.out_of_position_m, layout.roof_m, layout.track_m, layout.lift_m}) {
    if (std::abs(length_m) <= kFarthest_m) continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("[vehicle] holds {:g} m, and no cabin is so large; give metres", length_m), path);
  }
  if (!(layout.critical_m > 0.0 && layout.critical_m <= layout.out_of_position_m)) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("[vehicle] critical_m = {:g} must be above 0 and at most out_of_position_m = {:g}: it is "
                            "the front part of that zone",
                            layout.critical_m, layout.out_of_position_m),
                path);
  }
  if (!(layout.zone_half_width_m > 0.0)) {
    throw Error(ErrorKind::kBadInput, "[vehicle] zone_half_width_m must be above 0", path);
  }
  if (!(layout.track_m >= 0.0 && layout.lift_m >= 0.0)) {
    throw Error(ErrorKind::kBadInput, "[vehicle] track_m and lift_m are lengths of travel and must not be below 0",
                path);
  }
  if (!(layout.least_recline_rad <= layout.most_recline_rad)) {
    throw Error(ErrorKind::kBadInput, "[vehicle] least_recline_rad must not be above most_recline_rad", path);
  }
  for (const double recline_rad : {layout.least_recline_rad, layout.most_recline_rad}) {
    if (std::abs(recline_rad) <= kMostRecline_rad) continue;
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("[vehicle] holds a recline of {:g} rad, and no back rest leans so far; give radians", recline_rad),
        path);
  }
  if (!(layout.roof_m > layout.zone_floor_m)) {
    throw Error(ErrorKind::kBadInput, "[vehicle] roof_m must be above zone_floor_m", path);
  }
}

// Boxes [m] in the vehicle frame.
void read_fixtures(const toml::table& file, const std::string& path, VehicleLayout& layout) {
  if (!file.contains("fixture")) return;
  const toml::array* sections = file["fixture"].as_array();
  const std::size_t most = layout.fixtures.size();
  if (sections == nullptr || !sections->is_array_of_tables() || sections->size() > most) {
    throw Error(ErrorKind::kBadInput, fmt::format("needs [[fixture]] with low_m and high_m, at most {} of them", most),
                path);
  }
  for (std::size_t i = 0; i < sections->size(); ++i) {
    VehicleSection section("[fixture]", *sections->get(i)->as_table(), path);
    const auto low = section.numbers<3>("low_m"), high = section.numbers<3>("high_m");
    section.finish();
    const Eigen::AlignedBox3d box{Eigen::Vector3d(low.data()), Eigen::Vector3d(high.data())};
    if (box.isEmpty()) {
      throw Error(ErrorKind::kBadInput, "[[fixture]] low_m must lie below high_m in x, y and z", path);
    }
    if (!(box.min().x() >= layout.dashboard_x_m - layout.critical_m && box.sizes().maxCoeff() <= kFarthest_m)) {
      throw Error(
          ErrorKind::kBadInput,
          fmt::format("[[fixture]] reaches from x = {:g} m on, and what is not counted there may be somebody; it "
                      "must not leave the critical zone, which begins at x = {:g} m",
                      box.min().x(), layout.dashboard_x_m - layout.critical_m),
          path);
    }
    layout.fixtures[i] = box;
  }
}

}  // namespace

VehicleSection::VehicleSection(const toml::table& file, const char* name, const std::string& path)
    : name_(name), path_(path) {
  const toml::table* table = file[name].as_table();
  if (table == nullptr) throw Error(ErrorKind::kBadInput, fmt::format("has no section [{}]; add it", name), path);
  left_ = *table;
}

bool VehicleSection::take(const char* key) {
  known_.emplace_back(key);
  const bool there = left_.contains(key);
  if (!there && missing_.empty()) missing_ = key;
  return there;
}

double VehicleSection::number(const char* key) {
  if (!take(key)) return 0.0;
  const auto value = left_[key].value<double>();
  if (!value || !std::isfinite(*value)) fail(key, "a number");
  left_.erase(key);
  return *value;
}

int VehicleSection::whole_number(const char* key, int low, int high) {
  if (!left_.contains(key)) return static_cast<int>(number(key));
  const double value = number(key);
  if (value != std::round(value) || value < low || value > high) {
    fail(key, fmt::format("a whole number from {} to {}", low, high));
  }
  return static_cast<int>(value);
}

Rigid3 VehicleSection::pose() {
  const auto q = numbers<4>("rotation_xyzw");
  const auto t = numbers<3>("translation_m");
  Rigid3 pose{Eigen::Quaterniond(q[3], q[0], q[1], q[2]), Eigen::Vector3d(t.data())};
  if (!missing_.empty()) return {};
  if (std::abs(pose.rotation.norm() - 1.0) > 1e-6) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("[{}] rotation_xyzw has no unit length; give six digits and more", name_), path_);
  }
  pose.rotation.normalize();
  if (!(pose.translation.norm() <= kFarthest_m)) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("[{}] translation_m is {:g} m long, and no cabin is so large; give metres", name_,
                            pose.translation.norm()),
                path_);
  }
  return pose;
}

void VehicleSection::finish() const {
  if (!left_.empty()) {
    const std::string key(left_.begin()->first.str());
    throw Error(ErrorKind::kBadInput,
                fmt::format("[{}] has an unknown key '{}'.{}", name_, key, did_you_mean(key, known_)), path_);
  }
  if (!missing_.empty()) {
    throw Error(ErrorKind::kBadInput, fmt::format("[{}] needs {}; add it", name_, missing_), path_);
  }
}

void VehicleSection::fail(const char* key, const std::string& wanted) const {
  throw Error(ErrorKind::kBadInput, fmt::format("[{}] needs {} = {}", name_, key, wanted), path_);
}

toml::table vehicle_file(const std::string& path) {
  try {
    return toml::parse(text_of_file(path), path);
  } catch (const toml::parse_error& error) {
    throw Error(ErrorKind::kBadInput, fmt::format("is not TOML: {}", error.description()),
                fmt::format("{}:{}", path, error.source().begin.line));
  }
}

VehicleLayout vehicle_layout_in(const toml::table& file, const std::string& path) {
  VehicleSection section(file, "vehicle", path);
  VehicleLayout layout;
  for (const auto& [key, value] :
       {std::pair("dashboard_x_m", &layout.dashboard_x_m), std::pair("dashboard_top_m", &layout.dashboard_top_m),
        std::pair("zone_floor_m", &layout.zone_floor_m), std::pair("zone_half_width_m", &layout.zone_half_width_m),
        std::pair("critical_m", &layout.critical_m), std::pair("out_of_position_m", &layout.out_of_position_m)}) {
    *value = section.number(key);
  }
  for (const auto& [key, value] :
       {std::pair("track_m", &layout.track_m), std::pair("lift_m", &layout.lift_m),
        std::pair("least_recline_rad", &layout.least_recline_rad),
        std::pair("most_recline_rad", &layout.most_recline_rad), std::pair("roof_m", &layout.roof_m)}) {
    section.read_if_there(key, *value);
  }
  section.finish();
  check(layout, path);
  read_fixtures(file, path, layout);
  return layout;
}

}  // namespace raybundle::apps
