// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace raybundle {

/// @param file  its name, for messages
/// @throws Error(kBadInput) `file:line: is not TOML: ...`, with a hint for the mistakes that people make most
toml::table toml_from_text(std::string_view text, const std::string& file);

/// Reads one table and remembers which keys it was asked for, so that the others can be refused.
///
/// Every complaint is an Error(kBadInput) that names file, line and field. A field that is missing, or of another type,
/// is one, unless a function says otherwise. Include in .cpp files only: the library is heavy.
class TomlReader {
 public:
  /// @param name  of the table in messages: [emitter]
  TomlReader(const toml::table& table, std::string name, std::string file);

  /// @param node  whose line is named; the table's when null
  [[noreturn]] void fail(const toml::node* node, const std::string& message) const;
  std::string place() const { return place(table_); }  ///< of the table: file:line
  std::string place(const toml::node& node) const;

  bool has(const std::string& key) { return get(key) != nullptr; }
  const toml::node* get(const std::string& key);                                     ///< null when it is missing
  std::optional<TomlReader> table(const std::string& key, const std::string& name);  ///< nothing when it is missing
  std::vector<TomlReader> tables(const std::string& key);                            ///< of [[key]], or the one [key]

  double number(const std::string& key);  ///< a finite one
  double number(const std::string& key, double fallback);
  double positive(const std::string& key);
  double positive(const std::string& key, double fallback);
  double at_least_zero(const std::string& key, double fallback);
  double share(const std::string& key, double fallback);  ///< 0 to 1
  int whole(const std::string& key, int low, int high);
  std::string text(const std::string& key);  ///< not empty
  std::string text(const std::string& key, const std::string& fallback);
  std::vector<std::string> texts(const std::string& key);  ///< one, or a list of them
  bool flag(const std::string& key, bool fallback);
  std::vector<double> numbers(const std::string& key, std::size_t size);
  std::vector<std::vector<double>> rows_of_numbers(const std::string& key, std::size_t size);  ///< empty when missing

  std::vector<std::string> keys() const;
  void refuse_unknown_keys() const;

 private:
  const toml::node& need(const std::string& key);
  double finite(const toml::node& node, const std::string& key) const;
  std::vector<double> numbers_of(const toml::node& node, const std::string& key, std::size_t size) const;

  const toml::table& table_;
  std::string name_, file_;
  std::vector<std::string> known_;
};

/// The three numbers under a key.
Eigen::Vector3d vector3(TomlReader& reader, const std::string& key);
/// The same, or the fallback.
Eigen::Vector3d vector3(TomlReader& reader, const std::string& key, const Eigen::Vector3d& fallback);

}  // namespace raybundle
