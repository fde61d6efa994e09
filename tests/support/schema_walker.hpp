// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

namespace raybundle::testing {

/// Checks a value against the part of JSON Schema (draft 2020-12) that our schemas use. A keyword that this walker does
/// not know is a complaint too, so that a schema cannot promise what is not checked.
class SchemaWalker {
 public:
  using Json = nlohmann::json;

  explicit SchemaWalker(Json schema) : root_(std::move(schema)) {}

  /// What is wrong, one line each; empty when the value conforms.
  std::vector<std::string> complaints(const Json& value) const {
    std::vector<std::string> found;
    walk(root_, value, "", found);
    return found;
  }

  /// Keys that the schema does not speak of, where it names any; empty when it knows all that is written.
  std::vector<std::string> unknown(const Json& value) const {
    std::vector<std::string> found;
    look(root_, value, "", found);
    return found;
  }

 private:
  void look(const Json& schema, const Json& value, const std::string& path, std::vector<std::string>& found) const {
    if (schema.contains("$ref")) {
      return look(root_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))), value, path, found);
    }
    for (const auto& [key, part] : value.items()) {
      const std::string here = path + "/" + key;
      if (value.is_array() && schema.contains("items")) look(schema["items"], part, here, found);
      if (!value.is_object() || !schema.contains("properties")) continue;
      const bool known = schema["properties"].contains(key);
      if (known) look(schema["properties"][key], part, here, found);
      if (!known && !schema.contains("additionalProperties")) found.push_back(here);
    }
  }

  static bool is_type(const Json& value, const std::string& type) {
    return (type == "object" && value.is_object()) || (type == "array" && value.is_array()) ||
           (type == "string" && value.is_string()) || (type == "number" && value.is_number()) ||
           (type == "integer" && value.is_number_integer()) || (type == "boolean" && value.is_boolean()) ||
           (type == "null" && value.is_null());
  }

  void walk(const Json& schema, const Json& value, const std::string& path, std::vector<std::string>& found) const {
    if (schema.is_boolean()) {
      if (!schema.get<bool>()) found.push_back(path + " must not be there");
      return;
    }
    for (const auto& [keyword, wanted] : schema.items()) {
      if (!holds(schema, keyword, wanted, value, path, found)) found.push_back(path + " breaks " + keyword);
    }
  }

  bool holds(const Json& schema, const std::string& keyword, const Json& wanted, const Json& value,
             const std::string& path, std::vector<std::string>& found) const {
    for (const char* told : {"$schema", "title", "description", "$defs", "contentEncoding", "contentMediaType"}) {
      if (keyword == told) return true;
    }
    if (keyword == "$ref") {
      walk(root_.at(Json::json_pointer(wanted.get<std::string>().substr(1))), value, path, found);
      return true;
    }
    if (keyword == "type" && wanted.is_string()) return is_type(value, wanted);
    if (keyword == "type") {
      return std::ranges::any_of(wanted, [&](const Json& type) { return is_type(value, type); });
    }
    if (keyword == "const") return value == wanted;
    if (keyword == "enum") return std::ranges::find(wanted, value) != wanted.end();
    if (keyword == "minimum") return !value.is_number() || value >= wanted;
    if (keyword == "maximum") return !value.is_number() || value <= wanted;
    if (keyword == "minLength") return !value.is_string() || value.get<std::string>().size() >= wanted;
    if (keyword == "minItems") return !value.is_array() || value.size() >= wanted;
    if (keyword == "maxItems") return !value.is_array() || value.size() <= wanted;
    if (keyword == "pattern") {
      return !value.is_string() || std::regex_search(value.get<std::string>(), std::regex(wanted.get<std::string>()));
    }
    if (keyword == "required") {
      return std::ranges::all_of(wanted, [&](const Json& key) { return value.contains(key.get<std::string>()); });
    }
    if (keyword == "items") {
      for (std::size_t i = 0; value.is_array() && i < value.size(); ++i) {
        walk(wanted, value[i], path + "/" + std::to_string(i), found);
      }
      return true;
    }
    if (keyword == "properties" || keyword == "additionalProperties") {
      const Json known = schema.value("properties", Json::object());
      for (const auto& [key, part] : value.items()) {
        if (!value.is_object()) break;
        if (keyword == "properties" && known.contains(key)) walk(known[key], part, path + "/" + key, found);
        if (keyword == "additionalProperties" && !known.contains(key)) walk(wanted, part, path + "/" + key, found);
      }
      return true;
    }
    found.push_back("the walker does not know " + keyword);
    return true;
  }

  Json root_;
};

}  // namespace raybundle::testing
