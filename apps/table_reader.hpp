// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle::apps {

/// Reads one table of a TOML file and remembers which keys it knows, so that the others can be refused.
class TableReader {
 public:
  TableReader(const toml::table& table, std::string name, std::string file)
      : table_(table), name_(std::move(name)), file_(std::move(file)) {}

  [[noreturn]] void fail(const toml::node* node, const std::string& message) const {
    const auto line = (node != nullptr ? node->source() : table_.source()).begin.line;
    throw Error(ErrorKind::kBadInput, message, fmt::format("{}:{}", file_, line));
  }

  const toml::node* get(const std::string& key) {
    known_.push_back(key);
    return table_.get(key);
  }

  template <typename T>
  std::optional<T> value(const std::string& key, const char* what) {
    const toml::node* node = get(key);
    if (node == nullptr) return std::nullopt;
    std::optional<T> value = node->value<T>();
    if (!value) fail(node, fmt::format("{}.{} must be {}", name_, key, what));
    return value;
  }

  std::string text(const std::string& key) {
    const std::optional<std::string> found = value<std::string>(key, "a text in quotes");
    if (!found || found->empty()) fail(nullptr, fmt::format("{} needs a field '{}'", name_, key));
    return *found;
  }

  std::vector<std::string> texts(const std::string& key) {
    const toml::node* node = get(key);
    if (node == nullptr) fail(nullptr, fmt::format("{} needs a field '{}'", name_, key));
    if (node->is_string()) return {**node->as_string()};
    std::vector<std::string> all;
    if (const toml::array* array = node->as_array()) {
      for (const toml::node& entry : *array) {
        if (!entry.is_string()) fail(&entry, fmt::format("{}.{} must be a text or a list of texts", name_, key));
        all.push_back(**entry.as_string());
      }
    }
    if (all.empty()) fail(node, fmt::format("{}.{} must be a text or a list of texts", name_, key));
    return all;
  }

  void refuse_unknown_keys() const {
    for (const auto& [key, node] : table_) {
      const std::string name(key.str());
      if (std::ranges::find(known_, name) != known_.end()) continue;
      fail(&node, fmt::format("{} has an unknown field '{}'.{}", name_, name, did_you_mean(name, known_)));
    }
  }

 private:
  const toml::table& table_;
  std::string name_, file_;
  std::vector<std::string> known_;
};

/// The tables under a key that may be written once, [key], or several times, [[key]].
inline std::vector<const toml::table*> tables(TableReader& root, const std::string& key) {
  const toml::node* node = root.get(key);
  std::vector<const toml::table*> found;
  if (node == nullptr) return found;
  if (const toml::table* table = node->as_table()) return {table};
  if (const toml::array* array = node->as_array()) {
    for (const toml::node& entry : *array) found.push_back(entry.as_table());
  }
  if (found.empty() || std::ranges::find(found, nullptr) != found.end()) {
    root.fail(node, fmt::format("'{0}' must be a section, [{0}] or [[{0}]]", key));
  }
  return found;
}

}  // namespace raybundle::apps
