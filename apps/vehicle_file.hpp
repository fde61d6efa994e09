// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle::apps {

/// A section of vehicle.toml. Keys are taken one after the other; a key that is not there counts as zero until
/// finish(), which knows what else stands there and was perhaps meant. Include in .cpp files only: it is heavy.
class VehicleSection {
 public:
  /// @throws Error(kBadInput) when there is no such section
  VehicleSection(const toml::table& file, const char* name, const std::string& path);

  /// One of several sections of that name.
  VehicleSection(std::string name, toml::table section, std::string path)
      : name_(std::move(name)), path_(std::move(path)), left_(std::move(section)) {}

  double number(const char* key);
  int whole_number(const char* key, int low, int high);
  void read_if_there(const char* key, double& value) {
    known_.emplace_back(key);
    if (left_.contains(key)) value = number(key);
  }

  template <std::size_t kSize>
  std::array<double, kSize> numbers(const char* key) {
    std::array<double, kSize> values{};
    if (!take(key)) return values;
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

  /// rotation_xyzw and translation_m: the pose of the sensor's frame in the vehicle.
  Rigid3 pose();

  /// @throws Error(kBadInput) naming a key that nobody took, or that was to be taken and is not there
  void finish() const;

 private:
  bool take(const char* key);
  [[noreturn]] void fail(const char* key, const std::string& wanted) const;

  std::string name_, path_;
  toml::table left_;
  std::vector<std::string> known_;
  std::string missing_;  // the first one
};

/// @throws Error(kIo) when it cannot be read, Error(kBadInput) naming the line when it is no TOML
toml::table vehicle_file(const std::string& path);

/// The section [vehicle], of which the seat's travel and the roof may be left out, and the sections [[fixture]].
VehicleLayout vehicle_layout_in(const toml::table& file, const std::string& path);

}  // namespace raybundle::apps
