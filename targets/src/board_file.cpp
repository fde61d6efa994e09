// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/board_file.hpp"

#include <fmt/format.h>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/targets/board_kind.hpp"
#include "raybundle/targets/board_toml.hpp"

namespace raybundle {
namespace {

namespace fs = std::filesystem;

// A TOML basic string.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') result += '\\';
    if (static_cast<unsigned char>(letter) < 0x20 || letter == 0x7f) {
      result += fmt::format("\\u{:04X}", static_cast<int>(letter));
    } else {
      result += letter;
    }
  }
  return result + "\"";
}

std::string text_of(const FieldValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return quoted(*text);
  return std::visit([](const auto& plain) { return fmt::format("{}", plain); }, value);
}

}  // namespace

std::string toml_of(const Board& board) {
  const BoardKind& kind = board_kind_of(board);
  std::string text = fmt::format("[target]\nkind = {}\n", quoted(kind.name));
  for (const BoardField& field : kind.fields) {
    const std::string line = fmt::format("{} = {}", field.name, text_of(field.get(board)));
    if (field.required || field.get(board) != field.get(kind.empty)) {
      text += fmt::format("{:<24} # {}\n", line, field.help);
    }
  }
  return text;
}

Board board_from_word_or_toml(const std::string& word_or_path) {
  return word_or_path.ends_with(".toml") ? read_board_toml(word_or_path) : board_from_word(word_or_path);
}

Board board_from_toml_text(const std::string& text, const std::string& where, const fs::path& folder) {
  const toml::table file = toml_from_text(text, where);
  auto section = TomlReader(file, "the file", where).table("target", "[target]");
  if (!section) throw Error(ErrorKind::kBadInput, "there is no [target] section, which describes the board", where);
  return board_from_toml(*section, folder);
}

Board read_board_toml(const fs::path& path) {
  return board_from_toml_text(text_of_file(path), path.string(), path.parent_path());
}

void write_board_toml(const Board& board, const fs::path& path) {
  Board written = board;
  if (auto* set = std::get_if<PointSet>(&written)) {
    set->file = fs::proximate(set->file, fs::absolute(path).parent_path()).generic_string();
  }
  write_file_whole(path, fmt::format("# raybundle target {}\n{}", word_of(board), toml_of(written)));
}

}  // namespace raybundle
