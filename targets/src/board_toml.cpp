// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/board_toml.hpp"

#include <fmt/format.h>

#include <limits>

#include "board_point_set.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board_kind.hpp"

namespace raybundle {
namespace {

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

const BoardKind& kind_of(TomlReader& reader) {
  const toml::node* node = reader.get("kind");
  if (node == nullptr) reader.fail(nullptr, "[target] has no kind; write for example kind = \"chessboard\"");
  const auto name = node->value_exact<std::string>();
  if (!name) reader.fail(node, "kind must be a text in double quotes, as kind = \"chessboard\"");
  try {
    return board_kind_named(*name);
  } catch (const Error& error) {
    reader.fail(node, error.what());
  }
}

void set_field(Board& board, const BoardKind& kind, const BoardField& field, TomlReader& reader) {
  const toml::node* node = reader.get(field.name);
  if (node == nullptr) {
    if (!field.required) return;
    reader.fail(nullptr, fmt::format("[target] has no {}; a {} needs it: {}", field.name, kind.name, field.help));
  }
  const auto value = value_of(field.form, *node);
  if (!value) reader.fail(node, fmt::format("{} must be {}: {}", field.name, type_in_words(field.form), field.help));
  field.set(board, *value);
}

}  // namespace

Board board_from_toml(TomlReader& reader, const std::filesystem::path& folder) {
  const BoardKind& kind = kind_of(reader);
  for (const BoardField& field : kind.fields) reader.get(field.name);
  reader.refuse_unknown_keys();
  Board board = kind.empty;
  for (const BoardField& field : kind.fields) set_field(board, kind, field, reader);
  load_points(board, folder);
  try {
    check(board);
  } catch (const Error& error) {
    reader.fail(nullptr, error.what());
  }
  return board;
}

}  // namespace raybundle
