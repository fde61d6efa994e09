// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "foreign_lens.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

namespace raybundle {
namespace {

// Index of a parameter of ours; nothing for `0`. `f` is that of fx.
std::optional<int> index_of(ModelId model, std::string_view place) {
  const std::vector<std::string_view> names = parameter_names(model);
  const auto found = std::ranges::find(names, place == "f" ? "fx" : place);
  if (found == names.end()) return std::nullopt;
  return static_cast<int>(found - names.begin());
}

}  // namespace

ForeignLens foreign_lens(std::string_view name, std::string_view model, std::string_view places, double max_angle_rad) {
  return {name, *model_named(model), places, max_angle_rad};
}

std::vector<std::string_view> places_of(const ForeignLens& lens) {
  std::vector<std::string_view> places;
  for (std::string_view rest = lens.places; !rest.empty();) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    places.push_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return places;
}

std::vector<int> parameters_without_place(const ForeignLens& lens) {
  std::set<int> with;
  for (const std::string_view place : places_of(lens)) {
    if (const auto index = index_of(lens.model, place)) with.insert(*index);
    if (place == "f") with.insert(1);
  }
  std::vector<int> without;
  for (int i = 0; i < static_cast<int>(parameter_names(lens.model).size()); ++i) {
    if (!with.contains(i)) without.push_back(i);
  }
  return without;
}

std::vector<double> values_of(const ForeignLens& lens, const Camera& camera) {
  std::vector<double> values;
  for (const std::string_view place : places_of(lens)) {
    const auto index = index_of(lens.model, place);
    values.push_back(index ? camera.parameters[*index] : 0.0);
  }
  return values;
}

std::pair<Camera, std::string> camera_from_values(const ForeignLens& lens, ImageSize size,
                                                  const std::vector<double>& values) {
  const std::vector<std::string_view> places = places_of(lens);
  Camera camera = start_camera(lens.model, size, 1.0);
  if (values.size() != places.size()) {
    return {camera, fmt::format("has {} numbers where {} are expected: {}", values.size(), places.size(), lens.places)};
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!std::isfinite(values[i])) return {camera, fmt::format("has {} for {}", values[i], places[i])};
    if (const auto index = index_of(lens.model, places[i])) {
      camera.parameters[*index] = values[i];
    } else if (values[i] != 0.0) {
      return {camera, fmt::format("has {} as its number {}, a coefficient that no lens here has: it must be 0",
                                  values[i], i + 1)};
    }
    if (places[i] == "f") camera.parameters[1] = values[i];
  }
  if (!(camera.fx() > 0 && camera.fy() > 0)) return {camera, "has a focal length that is not positive"};
  return {camera, ""};
}

bool holds(const ForeignFormat& format, const ForeignLens& lens, const Camera& camera) {
  if (lens.model != camera.model) return false;
  if (lens.places.starts_with("f ") && camera.fx() != camera.fy()) return false;
  if (format.takes != nullptr && !format.takes(lens, camera)) return false;
  const Camera start = start_camera(camera.model, camera.size, 1.0);
  return std::ranges::all_of(parameters_without_place(lens),
                             [&](int i) { return camera.parameters[i] == start.parameters[i]; });
}

const ForeignLens* lens_for(const ForeignFormat& format, const Camera& camera) {
  const auto found =
      std::ranges::find_if(format.lenses, [&](const ForeignLens& lens) { return holds(format, lens, camera); });
  return found == format.lenses.end() ? nullptr : &*found;
}

const ForeignLens* lens_named(const ForeignFormat& format, std::string_view name, std::size_t values) {
  const ForeignLens* first = nullptr;
  for (const ForeignLens& lens : format.lenses) {
    if (lens.name != name) continue;
    if (places_of(lens).size() == values) return &lens;
    if (first == nullptr) first = &lens;
  }
  return first;
}

std::string known_lenses(const ForeignFormat& format) {
  std::vector<std::string_view> names;
  for (const ForeignLens& lens : format.lenses) {
    if (std::ranges::find(names, lens.name) == names.end()) names.push_back(lens.name);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string real_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find('.') != text.npos) return text;
  return text.insert(std::min(text.find('e'), text.size()), ".0");
}

std::string list_text(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(real_text(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string opencv_matrix_text(const std::string& key, int rows, int columns, const std::vector<double>& data) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: {}\n", key, rows, columns,
                     list_text(data));
}

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string file_stem(const std::string& camera) {
  std::string stem = camera;
  for (char& c : stem) {
    if (c == '/' || static_cast<unsigned char>(c) <= ' ') c = '_';
  }
  return stem;
}

std::string stem_of(const std::string& path) {
  const std::string name = path.substr(path.find_last_of('/') + 1);
  return name.substr(0, name.find_last_of('.'));
}

std::string numbered_camera(std::size_t index) { return fmt::format("cam{}", index); }

}  // namespace raybundle
