// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// A parsed text with the name that messages call it by. The text must outlive the document.
struct JsonDocument {
  std::string_view text;
  std::string name;
  nlohmann::json value;
};

/// An array at the top of a text that is too long to be parsed at once: its entries are, one by one.
struct LongJsonArray {
  std::string key;
  std::vector<std::string_view> entries = {};  ///< texts, all of them objects
};

/// Parses a text.
///
/// @param long_array  left out of the document, which has an empty array there, when all of its entries are objects
/// @throws Error(kBadInput) with the line of the first mistake, or naming a key that an object has twice
JsonDocument parse_json(std::string_view text, const std::string& name, LongJsonArray* long_array = nullptr);

/// A value in a document that knows its place, so that every complaint names line and key. A node points to the node it
/// was taken from, which must stay where it is: nodes can only be taken from named variables.
class JsonNode {
 public:
  explicit JsonNode(const JsonDocument& document) : document_(&document), value_(&document.value) {}

  JsonNode at(std::string_view key) const&;  ///< throws when the key is missing or this is no object
  std::optional<JsonNode> find(std::string_view key) const&;
  JsonNode operator[](std::size_t index) const&;
  JsonNode at(std::string_view key) const&& = delete;
  std::optional<JsonNode> find(std::string_view key) const&& = delete;
  JsonNode operator[](std::size_t index) const&& = delete;

  /// An entry of an array that was left out of the document.
  JsonNode entry(std::size_t index, const nlohmann::json& value) const&;
  JsonNode entry(std::size_t index, const nlohmann::json& value) const&& = delete;

  std::size_t array_size() const;                                 ///< throws when this is no array
  void expect_array_size(std::size_t size) const;                 ///< throws when this is no array of that size
  std::vector<std::string> keys() const;                          ///< throws when this is no object
  void expect_keys(const std::vector<std::string>& known) const;  ///< throws "did you mean" for any other key

  double number() const;
  double positive_number() const;
  int whole_number(int low, int high) const;
  bool boolean() const;
  std::string text() const;
  std::string name() const;  ///< a text that is not empty
  template <int size>
  Eigen::Matrix<double, size, 1> vector() const {
    expect_array_size(size);
    Eigen::Matrix<double, size, 1> values;
    for (int i = 0; i < size; ++i) values[i] = (*this)[static_cast<std::size_t>(i)].number();
    return values;
  }
  ModelId model() const;
  ImageSize image_size() const;  ///< of an object with width and height
  Rigid3 rigid3() const;         ///< of an object with rotation_xyzw and translation_m

  bool is_number() const { return value_->is_number(); }
  bool is_null() const { return value_->is_null(); }

  /// Throws Error(kBadInput, "name:line: cameras[1].model " + message).
  [[noreturn]] void fail(const std::string& message) const;

 private:
  JsonNode() = default;
  std::string path() const;  ///< cameras[1].parameters.k2
  int line() const;          ///< where the value begins, from 1
  [[noreturn]] void fail_type(const char* wanted) const;

  const JsonDocument* document_ = nullptr;
  const nlohmann::json* value_ = nullptr;
  const JsonNode* parent_ = nullptr;
  std::string_view key_;   ///< in the parent, when it is an object
  std::size_t index_ = 0;  ///< in the parent, when it is an array
};

/// The rotation that four numbers of a node are.
///
/// @param node  that complaints name, when its length is not 1
Eigen::Quaterniond unit_quaternion(const JsonNode& node, Eigen::Quaterniond quaternion);

/// Checks the head of one of our files: its format and its version.
void expect_format(const JsonNode& root, const std::string& format, int version);

}  // namespace raybundle
