// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "yaml_node.hpp"

#include <cmath>
#include <set>

#include "../image_side.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rigid3_matrix.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/number.hpp"

namespace raybundle {
namespace {

constexpr const char* kOpenCvHead = "%YAML:1.0";

std::string place(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : file + ":" + std::to_string(mark.line + 1);
}

}  // namespace

YamlNode YamlNode::parse(const NamedText& file) {
  std::string text = file.text;
  if (text.starts_with(kOpenCvHead)) text.front() = '#';
  try {
    // The first document; YAML::LoadAll, which would tell of others, does not end on some texts that are no YAML.
    YamlNode root(YAML::Load(text), file.name, "");
    int nodes = 0;
    if (!root.node_.IsMap()) throw Error(ErrorKind::kBadInput, "has no keys; is this the right file?", file.name);
    root.refuse_keys_that_stand_twice(nodes);
    return root;
  } catch (const YAML::Exception& error) {
    throw Error(ErrorKind::kBadInput, "this is not valid YAML: " + error.msg + "; correct it or write the file again",
                place(file.name, error.mark));
  }
}

void YamlNode::refuse_keys_that_stand_twice(int& nodes) const {
  constexpr int kMostNodes = 100'000;  // aliases may stand for themselves
  if (++nodes > kMostNodes) fail("has too many values for a calibration; is this the right file?");
  if (node_.IsSequence()) {
    for (const YAML::Node& entry : node_) YamlNode(entry, file_, path_).refuse_keys_that_stand_twice(nodes);
  }
  if (!node_.IsMap()) return;
  std::set<std::string> seen;
  for (const auto& item : node_) {
    const std::string key = item.first.IsScalar() ? item.first.Scalar() : "";
    const YamlNode value(item.second, file_, path_.empty() ? key : path_ + "." + key);
    if (!seen.insert(key).second) value.fail("stands twice; leave one out");
    value.refuse_keys_that_stand_twice(nodes);
  }
}

YamlNode YamlNode::at(const std::string& key) const {
  if (const auto found = find(key)) return *found;
  YamlNode(node_, file_, path_.empty() ? key : path_ + "." + key).fail("is missing; add it");
}

std::optional<YamlNode> YamlNode::find(const std::string& key) const {
  if (!node_.IsMap()) fail("is no map of keys; correct it");
  const YAML::Node& node = node_;  // only a constant node is not given the key that is asked for
  const YAML::Node found = node[key];
  if (!found.IsDefined()) return std::nullopt;
  return YamlNode(found, file_, path_.empty() ? key : path_ + "." + key);
}

std::optional<YamlNode> YamlNode::find_first(std::initializer_list<const char*> keys) const {
  for (const char* key : keys) {
    if (auto found = find(key)) return found;
  }
  return std::nullopt;
}

double YamlNode::number() const {
  const auto value = node_.IsScalar() ? number_from<double>(node_.Scalar()) : std::nullopt;
  if (!value || !std::isfinite(*value)) fail("is no number; correct it");
  return *value;
}

int YamlNode::whole_number(int low, int high) const {
  const double value = number();
  if (value != std::floor(value) || value < low || value > high) {
    fail("must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  }
  return static_cast<int>(value);
}

std::string YamlNode::text() const {
  if (!node_.IsScalar()) fail("is no text; correct it");
  return node_.Scalar();
}

std::vector<double> YamlNode::numbers() const {
  if (!node_.IsSequence()) fail("is no list of numbers; correct it");
  std::vector<double> values;
  for (const YAML::Node& entry : node_) values.push_back(YamlNode(entry, file_, path_).number());
  return values;
}

std::vector<double> YamlNode::numbers(std::size_t size) const {
  std::vector<double> values = numbers();
  if (values.size() == size) return values;
  fail("has " + std::to_string(values.size()) + " numbers where " + std::to_string(size) + " are expected; correct it");
}

std::vector<std::vector<double>> YamlNode::rows(std::size_t size) const {
  if (!node_.IsSequence() || node_.size() != size) fail("must have " + std::to_string(size) + " rows; correct it");
  std::vector<std::vector<double>> rows;
  for (const YAML::Node& entry : node_) rows.push_back(YamlNode(entry, file_, path_).numbers(size));
  return rows;
}

std::vector<std::string> YamlNode::keys() const {
  if (!node_.IsMap()) fail("is no map of keys; correct it");
  std::vector<std::string> keys;
  for (const auto& item : node_) keys.push_back(item.first.IsScalar() ? item.first.Scalar() : "");
  return keys;
}

void YamlNode::fail(const std::string& message) const {
  throw Error(ErrorKind::kBadInput, (path_.empty() ? "the file" : path_) + " " + message, place(file_, node_.Mark()));
}

ImageSize image_size_from(const YamlNode& width, const YamlNode& height) {
  return {width.whole_number(1, kMaxImageSide_px), height.whole_number(1, kMaxImageSide_px)};
}

ImageSize image_size_from(const YamlNode& width_and_height) {
  const std::vector<double> size = width_and_height.numbers(2);
  for (const double side : size) {
    if (side != std::floor(side) || side < 1 || side > kMaxImageSide_px) {
      width_and_height.fail("must be a width and a height in pixels");
    }
  }
  return {static_cast<int>(size[0]), static_cast<int>(size[1])};
}

std::vector<double> pinhole_values(const YamlNode& camera_matrix) {
  const std::vector<double> k = camera_matrix.numbers(9);
  if (k[1] != 0.0) camera_matrix.fail("has a skew, which no lens here has");
  if (k[3] != 0.0 || k[6] != 0.0 || k[7] != 0.0 || k[8] != 1.0) {
    camera_matrix.fail("is not fx 0 cx, 0 fy cy, 0 0 1 by rows; is it transposed?");
  }
  return {k[0], k[4], k[2], k[5]};
}

Rigid3 rigid3_from(const YamlNode& node, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  constexpr double kRounding = 1e-3;  // of a matrix that was written with four digits
  const auto transform = rigid3_from_matrix(rotation, translation, kRounding);
  if (!transform) node.fail("is not a rotation; correct it");
  return *transform;
}

Rigid3 rigid3_from(const YamlNode& node, const Eigen::Matrix4d& matrix) {
  constexpr double kRounding = 1e-6;
  if (!((matrix.row(3) - Eigen::RowVector4d::UnitW()).cwiseAbs().maxCoeff() < kRounding)) {
    node.fail("is not a transform by rows, the last of them 0 0 0 1; is it transposed?");
  }
  return rigid3_from(node, matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>());
}

}  // namespace raybundle
