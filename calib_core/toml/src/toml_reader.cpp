// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/toml/toml_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle {
namespace {

std::string hint(std::string_view text, std::string_view problem) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const auto says = [&](std::string_view part) { return problem.find(part) != std::string_view::npos; };
  if (first != std::string_view::npos && text[first] == '{') return "; this is JSON";
  if (says("escape sequence")) return "; write / for \\ in paths";
  if (says("determine value type")) return "; text stands in quotes, as in kind = \"chessboard\"";
  if (says("redefine existing table")) return "; of several write each in double brackets, as [[camera]]";
  return "";
}

}  // namespace

toml::table toml_from_text(std::string_view text, const std::string& file) {
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("is not TOML: {}{}", error.description(), hint(text, error.description())),
                fmt::format("{}:{}", file, error.source().begin.line));
  }
}

TomlReader::TomlReader(const toml::table& table, std::string name, std::string file)
    : table_(table), name_(std::move(name)), file_(std::move(file)) {}

std::string TomlReader::place(const toml::node& node) const {
  const auto line = node.source().begin.line;
  return line == 0 ? file_ : fmt::format("{}:{}", file_, line);
}

void TomlReader::fail(const toml::node* node, const std::string& message) const {
  throw Error(ErrorKind::kBadInput, message, node != nullptr ? place(*node) : place());
}

const toml::node* TomlReader::get(const std::string& key) {
  if (std::ranges::find(known_, key) == known_.end()) known_.push_back(key);
  return table_.get(key);
}

const toml::node& TomlReader::need(const std::string& key) {
  const toml::node* node = get(key);
  if (node != nullptr) return *node;
  std::vector<std::string> others;
  for (const std::string& other : keys()) {
    if (std::ranges::find(known_, other) == known_.end()) others.push_back(other);
  }
  const auto meant = closest(key, others);
  fail(nullptr, fmt::format("{} needs a field '{}'", name_, key) + (meant ? fmt::format("; it has '{}'", *meant) : ""));
}

std::optional<TomlReader> TomlReader::table(const std::string& key, const std::string& name) {
  const toml::node* node = get(key);
  if (node == nullptr) return std::nullopt;
  if (!node->is_table()) fail(node, fmt::format("'{}' must be a section, {}", key, name));
  return TomlReader(*node->as_table(), name, file_);
}

std::vector<TomlReader> TomlReader::tables(const std::string& key) {
  const std::string name = fmt::format("[[{}]]", key);
  const toml::node* node = get(key);
  if (node == nullptr) return {};
  if (node->is_table()) return {TomlReader(*node->as_table(), fmt::format("[{}]", key), file_)};
  std::vector<TomlReader> found;
  if (const toml::array* array = node->as_array()) {
    for (const toml::node& entry : *array) {
      if (!entry.is_table()) fail(&entry, fmt::format("'{}' must be sections, {}", key, name));
      found.emplace_back(*entry.as_table(), name, file_);
    }
  }
  if (found.empty()) fail(node, fmt::format("'{}' must be sections, {}", key, name));
  return found;
}

double TomlReader::finite(const toml::node& node, const std::string& key) const {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value)) fail(&node, fmt::format("{}.{} must be a number", name_, key));
  return *value;
}

double TomlReader::number(const std::string& key) { return finite(need(key), key); }

double TomlReader::number(const std::string& key, double fallback) {
  const toml::node* node = get(key);
  return node == nullptr ? fallback : finite(*node, key);
}

double TomlReader::positive(const std::string& key) {
  const toml::node& node = need(key);
  const double value = finite(node, key);
  if (!(value > 0)) fail(&node, fmt::format("{}.{} is {}, but must be above 0", name_, key, value));
  return value;
}

double TomlReader::positive(const std::string& key, double fallback) { return has(key) ? positive(key) : fallback; }

double TomlReader::at_least_zero(const std::string& key, double fallback) {
  const double value = number(key, fallback);
  if (!(value >= 0)) fail(table_.get(key), fmt::format("{}.{} is {}, but must not be below 0", name_, key, value));
  return value;
}

double TomlReader::share(const std::string& key, double fallback) {
  const double value = number(key, fallback);
  if (!(value >= 0 && value <= 1)) fail(table_.get(key), fmt::format("{}.{} must be 0 to 1", name_, key));
  return value;
}

int TomlReader::whole(const std::string& key, int low, int high) {
  const toml::node& node = need(key);
  const auto value = node.value_exact<int64_t>();
  if (!value || *value < low || *value > high) {
    fail(&node, fmt::format("{}.{} must be a whole number, {} to {}", name_, key, low, high));
  }
  return static_cast<int>(*value);
}

std::string TomlReader::text(const std::string& key) {
  const toml::node& node = need(key);
  const auto value = node.value_exact<std::string>();
  if (!value || value->empty()) fail(&node, fmt::format("{}.{} must be a text in quotes", name_, key));
  return *value;
}

std::string TomlReader::text(const std::string& key, const std::string& fallback) {
  return has(key) ? text(key) : fallback;
}

std::vector<std::string> TomlReader::texts(const std::string& key) {
  const toml::node& node = need(key);
  if (node.is_string()) return {text(key)};
  std::vector<std::string> all;
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& entry : *array) {
      if (!entry.is_string()) fail(&entry, fmt::format("{}.{} must be a text or a list of texts", name_, key));
      all.push_back(**entry.as_string());
    }
  }
  if (all.empty()) fail(&node, fmt::format("{}.{} must be a text or a list of texts", name_, key));
  return all;
}

bool TomlReader::flag(const std::string& key, bool fallback) {
  const toml::node* node = get(key);
  if (node == nullptr) return fallback;
  const auto value = node->value_exact<bool>();
  if (!value) fail(node, fmt::format("{}.{} must be true or false", name_, key));
  return *value;
}

std::vector<double> TomlReader::numbers_of(const toml::node& node, const std::string& key, std::size_t size) const {
  const toml::array* array = node.as_array();
  if (array == nullptr || array->size() != size) {
    fail(&node, fmt::format("{}.{} must be {} numbers in brackets", name_, key, size));
  }
  std::vector<double> values;
  for (const toml::node& entry : *array) values.push_back(finite(entry, key));
  return values;
}

std::vector<double> TomlReader::numbers(const std::string& key, std::size_t size) {
  return numbers_of(need(key), key, size);
}

std::vector<std::vector<double>> TomlReader::rows_of_numbers(const std::string& key, std::size_t size) {
  const toml::node* node = get(key);
  std::vector<std::vector<double>> rows;
  if (node == nullptr) return rows;
  if (!node->is_array()) fail(node, fmt::format("{}.{} must be a list of lists of {} numbers", name_, key, size));
  for (const toml::node& entry : *node->as_array()) rows.push_back(numbers_of(entry, key, size));
  return rows;
}

std::vector<std::string> TomlReader::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, node] : table_) names.emplace_back(key.str());
  return names;
}

void TomlReader::refuse_unknown_keys() const {
  for (const auto& [key, node] : table_) {
    const std::string name(key.str());
    if (std::ranges::find(known_, name) != known_.end()) continue;
    fail(&node, fmt::format("{} has an unknown field '{}'.{}", name_, name, did_you_mean(name, known_)));
  }
}

Eigen::Vector3d vector3(TomlReader& reader, const std::string& key) {
  const std::vector<double> values = reader.numbers(key, 3);
  return {values[0], values[1], values[2]};
}

Eigen::Vector3d vector3(TomlReader& reader, const std::string& key, const Eigen::Vector3d& fallback) {
  return reader.has(key) ? vector3(reader, key) : fallback;
}

}  // namespace raybundle
