// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/io/foreign_format.hpp"

namespace raybundle {

/// A value in a YAML text that knows its place, so that every complaint names line and key.
class YamlNode {
 public:
  /// Parses a text: a map of keys. OpenCV's first line `%YAML:1.0`, which is no YAML, is left out.
  ///
  /// @throws Error(kBadInput) with the line of the first mistake
  static YamlNode parse(const NamedText& file);

  YamlNode at(const std::string& key) const;  ///< throws when the key is missing or this is no map
  std::optional<YamlNode> find(const std::string& key) const;
  std::optional<YamlNode> find_first(std::initializer_list<const char*> keys) const;  ///< of keys that mean the same

  double number() const;
  int whole_number(int low, int high) const;
  std::string text() const;
  std::vector<double> numbers() const;                            ///< of a list
  std::vector<double> numbers(std::size_t size) const;            ///< throws unless there are so many
  std::vector<std::vector<double>> rows(std::size_t size) const;  ///< of a list of so many lists

  std::vector<std::string> keys() const;  ///< throws when this is no map

  /// Throws Error(kBadInput, "name:line: cam0.resolution " + message).
  [[noreturn]] void fail(const std::string& message) const;

 private:
  YamlNode(const YAML::Node& node, std::string file, std::string path)
      : node_(node), file_(std::move(file)), path_(std::move(path)) {}

  void refuse_keys_that_stand_twice(int& nodes) const;  ///< counts values

  YAML::Node node_;
  std::string file_;
  std::string path_;
};

/// Width and height of an image, each checked to be one.
ImageSize image_size_from(const YamlNode& width, const YamlNode& height);
ImageSize image_size_from(const YamlNode& width_and_height);

/// fx, fy, cx, cy of the nine numbers of a camera matrix by rows, checked to be one without skew.
std::vector<double> pinhole_values(const YamlNode& camera_matrix);

/// The transform of a rotation matrix, row by row, and a translation.
///
/// @param node  that complaints name, when the matrix is no rotation
Rigid3 rigid3_from(const YamlNode& node, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation);

/// The transform of a 4×4 matrix.
///
/// @param node  that complaints name, when the last row is not 0 0 0 1 or the matrix holds no rotation
Rigid3 rigid3_from(const YamlNode& node, const Eigen::Matrix4d& matrix);

}  // namespace raybundle
