// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace raybundle {

/// Reads one table and remembers which keys it knows, so that the others can be refused. Every complaint names file,
/// line and field.
class TomlReader {
 public:
  /// @param name  of the table in messages: [emitter]
  TomlReader(const toml::table& table, std::string name, std::string file);

  [[noreturn]] void fail(const toml::node* node, const std::string& message) const;

  bool has(const std::string& key) const { return table_.contains(key); }
  std::optional<TomlReader> table(const std::string& key, const std::string& name);  ///< nothing when it is missing
  std::vector<TomlReader> tables(const std::string& key);                            ///< of [[key]], or the one [key]

  double number(const std::string& key);  ///< a finite number; a missing one is an error, as in all that follow
  double number(const std::string& key, double fallback);
  double positive(const std::string& key);
  double positive(const std::string& key, double fallback);
  double at_least_zero(const std::string& key, double fallback);
  double share(const std::string& key, double fallback);  ///< 0 to 1
  int whole(const std::string& key, int low, int high);
  std::string text(const std::string& key);
  bool flag(const std::string& key, bool fallback);
  std::vector<double> numbers(const std::string& key, std::size_t size);
  std::vector<std::vector<double>> rows_of_numbers(const std::string& key, std::size_t size);  ///< empty when missing

  std::vector<std::string> keys() const;
  void refuse_unknown_keys() const;

 private:
  const toml::node* get(const std::string& key);
  const toml::node& need(const std::string& key);
  double finite(const toml::node& node, const std::string& key) const;
  std::vector<double> numbers_of(const toml::node& node, const std::string& key, std::size_t size) const;

  const toml::table& table_;
  std::string name_, file_;
  std::vector<std::string> known_;
};

/// The three numbers under a key, or the fallback.
Eigen::Vector3d vector3(TomlReader& reader, const std::string& key, const Eigen::Vector3d& fallback);

}  // namespace raybundle
