// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/board_toml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "board_point_set.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/targets/board_kind.hpp"

namespace raybundle {
namespace {

std::string place(const std::string& file, const toml::source_region& source) {
  return source.begin.line == 0 ? file : fmt::format("{}:{}", file, source.begin.line);
}

[[noreturn]] void refuse(const std::string& message, const std::string& where) {
  throw Error(ErrorKind::kBadInput, message, where);
}

std::string type_in_words(FieldForm form) {
  switch (form) {
    case FieldForm::kCount:
    case FieldForm::kNumber:
    case FieldForm::kBits:
      return "a whole number";
    case FieldForm::kLength:
      return "a number (metres)";
    case FieldForm::kRatio:
      return "a number";
    case FieldForm::kFlag:
      return "true or false";
    case FieldForm::kChoice:
    case FieldForm::kFile:
      return "a text in double quotes";
  }
  return "";
}

std::optional<FieldValue> value_of(FieldForm form, const toml::node& node) {
  switch (form) {
    case FieldForm::kCount:
    case FieldForm::kNumber:
    case FieldForm::kBits: {
      const auto whole = node.value_exact<int64_t>();
      constexpr int64_t kLimit = std::numeric_limits<int>::max();
      if (!whole || *whole < -kLimit || *whole > kLimit) return std::nullopt;
      return static_cast<int>(*whole);
    }
    case FieldForm::kLength:
    case FieldForm::kRatio:
      if (!node.is_number()) return std::nullopt;
      return node.value<double>();
    case FieldForm::kFlag:
      return node.value_exact<bool>();
    case FieldForm::kChoice:
    case FieldForm::kFile:
      return node.value_exact<std::string>();
  }
  return std::nullopt;
}

const BoardKind& kind_of(const toml::table& table, const std::string& file) {
  const toml::node* node = table.get("kind");
  const std::string table_place = place(file, table.source());
  if (node == nullptr) refuse("[target] has no kind; write for example kind = \"chessboard\"", table_place);
  const auto name = node->value_exact<std::string>();
  if (!name) refuse("kind must be a text in double quotes, as kind = \"chessboard\"", place(file, node->source()));
  try {
    return board_kind_named(*name);
  } catch (const Error& error) {
    refuse(error.what(), place(file, node->source()));
  }
}

void refuse_unknown_keys(const toml::table& table, const BoardKind& kind, const std::string& file,
                         const std::vector<std::string>& other_keys) {
  std::vector<std::string> known{"kind"};
  for (const BoardField& field : kind.fields) known.push_back(field.name);
  known.insert(known.end(), other_keys.begin(), other_keys.end());
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (std::ranges::find(known, name) != known.end()) continue;
    refuse(fmt::format("a {} has no field \"{}\".{}", kind.name, name, did_you_mean(name, known)),
           place(file, key.source()));
  }
}

void set_field(Board& board, const BoardKind& kind, const BoardField& field, const toml::table& table,
               const std::string& file) {
  const toml::node* node = table.get(field.name);
  if (node == nullptr) {
    if (!field.required) return;
    refuse(fmt::format("[target] has no {}; a {} needs it: {}", field.name, kind.name, field.help),
           place(file, table.source()));
  }
  const auto value = value_of(field.form, *node);
  if (!value) {
    refuse(fmt::format("{} must be {}: {}", field.name, type_in_words(field.form), field.help),
           place(file, node->source()));
  }
  field.set(board, *value);
}

}  // namespace

Board board_from_toml(const toml::table& table, const std::string& file, const std::filesystem::path& folder,
                      const std::vector<std::string>& other_keys) {
  const BoardKind& kind = kind_of(table, file);
  refuse_unknown_keys(table, kind, file, other_keys);
  Board board = kind.empty;
  for (const BoardField& field : kind.fields) set_field(board, kind, field, table, file);
  load_points(board, folder);
  try {
    check(board);
  } catch (const Error& error) {
    refuse(error.what(), place(file, table.source()));
  }
  return board;
}

}  // namespace raybundle
