// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "json_text.hpp"

#include <algorithm>

namespace raybundle {
namespace {

// One line. Bytes that are not UTF-8 (from file names) are replaced: a report must not fail on them. "<", which in JSON
// is always within a string, is spelt so that the text may stand in a <script> element as it is.
std::string flat_text(const OrderedJson& value) {
  std::string text = value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != text.npos; at = text.find('<', at)) text.replace(at, 1, "\\u003c");
  return text;
}

bool holds_plain_values(const OrderedJson& value) {
  return std::ranges::none_of(value, [](const OrderedJson& entry) { return entry.is_structured(); });
}

OrderedJson json_from_pairs(const std::vector<std::pair<std::string, std::string>>& pairs) {
  OrderedJson json = OrderedJson::array();
  for (const auto& [name, value] : pairs) json.push_back({{"name", name}, {"value", value}});
  return json;
}

/// How arrays are written, by their keys.
struct Layout {
  const std::vector<std::string>& lines;
  const LongArray* long_array;
};

void append(const LongArray& array, std::size_t indent, std::string& text) {
  if (array.size == 0) {
    text += "[]";
    return;
  }
  constexpr std::size_t kFirst = 100;  // entries, by whose length room is made for all of them
  const std::size_t begin = text.size();
  for (std::size_t i = 0; i < array.size; ++i) {
    text += i == 0 ? "[\n" : ",\n";
    text.append(indent + 2, ' ');
    text += flat_text(array.entry(i));
    if (i == kFirst) text.reserve(begin + (text.size() - begin) / kFirst * array.size * 11 / 10);
  }
  text += '\n';
  text.append(indent, ' ');
  text += ']';
}

void append(const OrderedJson& value, const Layout& layout, bool one_a_line, std::size_t indent, std::string& text) {
  if (value.empty() || !value.is_structured() || (value.is_array() && holds_plain_values(value))) {
    text += flat_text(value);
    return;
  }
  const std::string margin(indent + 2, ' ');
  text += value.is_array() ? '[' : '{';
  bool first = true;
  for (const auto& item : value.items()) {
    text += (first ? "\n" : ",\n") + margin;
    first = false;
    if (value.is_object()) text += flat_text(OrderedJson(item.key())) + ": ";
    if (indent == 0 && layout.long_array && item.key() == layout.long_array->key) {
      append(*layout.long_array, indent + 2, text);
    } else if (one_a_line || (value.is_array() && holds_plain_values(item.value()))) {
      text += flat_text(item.value());
    } else {
      const bool listed = value.is_object() && std::ranges::find(layout.lines, item.key()) != layout.lines.end();
      append(item.value(), layout, listed, indent + 2, text);
    }
  }
  text += "\n" + std::string(indent, ' ') + (value.is_array() ? ']' : '}');
}

}  // namespace

std::string pretty_text(const OrderedJson& value, const std::vector<std::string>& lines, const LongArray* long_array) {
  std::string text;
  append(value, {lines, long_array}, false, 0, text);
  text += '\n';
  return text;
}

OrderedJson json_from_vector(const Eigen::Ref<const Eigen::VectorXd>& values) {
  OrderedJson json = OrderedJson::array();
  for (const double value : values) json.push_back(value);
  return json;
}

OrderedJson json_from_rigid3(const Rigid3& b_from_a) {
  return {{"rotation_xyzw", json_from_vector(b_from_a.rotation.coeffs())},
          {"translation_m", json_from_vector(b_from_a.translation)}};
}

OrderedJson json_from_points(const Target& target) {
  OrderedJson points = OrderedJson::array();
  for (const TargetPoint& point : target.points) {
    points.push_back({point.id, point.x_in_target.x(), point.x_in_target.y(), point.x_in_target.z()});
  }
  return points;
}

OrderedJson json_from_symmetries(const Target& target) {
  OrderedJson symmetries = OrderedJson::array();
  for (const TargetSymmetry& symmetry : target.symmetries) symmetries.push_back(symmetry.ids);
  return symmetries;
}

OrderedJson json_from_shape(const BoardShape& shape) {
  return {{"bend_x_m", shape.bend_x_m}, {"bend_y_m", shape.bend_y_m}, {"twist_m", shape.twist_m}};
}

OrderedJson json_from_provenance(const Provenance& provenance) {
  OrderedJson json{{"command", provenance.command},
                   {"inputs", OrderedJson::array()},
                   {"options", json_from_pairs(provenance.options)},
                   {"versions", json_from_pairs(provenance.versions)}};
  for (const Provenance::Input& input : provenance.inputs) {
    json["inputs"].push_back({{"path", input.path}, {"sha256", input.sha256}});
  }
  return json;
}

}  // namespace raybundle
