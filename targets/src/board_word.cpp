// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "board_point_set.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/number.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/targets/board.hpp"
#include "raybundle/targets/board_kind.hpp"

namespace raybundle {
namespace {

// A decimal unit is a shift of the point, made in the text: so 23.4mm is the same double as 0.0234 in a file.
struct Unit {
  std::string_view name;
  std::string_view shift;
  double times;
};
constexpr std::array<Unit, 4> kUnits{{{"mm", "e-3", 1.0}, {"cm", "e-2", 1.0}, {"in", "", 0.0254}, {"m", "", 1.0}}};

[[noreturn]] void refuse(const std::string& reason) { throw Error(ErrorKind::kBadInput, reason); }

double length_of(std::string_view text) {
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.name)) continue;
    const std::string digits(text.substr(0, text.size() - unit.name.size()));
    const auto value = number_from<double>(digits + std::string(unit.shift));
    if (value) return *value * unit.times;
  }
  if (number_from<double>(text)) refuse(fmt::format("\"{}\" has no unit (mm, cm, m, in)", text));
  refuse(fmt::format("\"{}\" is not a length with its unit (mm, cm, m, in)", text));
}

int count_of(std::string_view text) {
  if (const auto value = number_from<int>(text)) return *value;
  refuse(fmt::format("\"{}\" is not a whole number", text));
}

std::string choice_of(const BoardField& field, std::string_view text) {
  if (std::ranges::find(field.choices, text) != field.choices.end()) return std::string(text);
  const auto near = closest(std::string(text), field.choices);
  refuse(fmt::format("there is no {} \"{}\"{}", field.name, text, near ? ", did you mean \"" + *near + "\"" : ""));
}

FieldValue value_of(const BoardField& field, std::string_view text) {
  switch (field.form) {
    case FieldForm::kCount:
    case FieldForm::kNumber:
      return count_of(text);
    case FieldForm::kLength:
      return length_of(text);
    case FieldForm::kRatio:
      if (const auto value = number_from<double>(text)) return *value;
      refuse(fmt::format("\"{}\" is not a number", text));
    case FieldForm::kBits:
      if (text.ends_with("bit")) return count_of(text.substr(0, text.size() - 3));
      refuse(fmt::format("\"{}\" is not a number of bits", text));
    case FieldForm::kChoice:
      return choice_of(field, text);
    case FieldForm::kFlag:
      return text == field.name;
    case FieldForm::kFile:
      return std::string(text);
  }
  refuse("unknown form of field");
}

// Whether an optional part of a word names this field; gives what stands for its value.
std::optional<std::string_view> optional_text(const BoardField& field, std::string_view part) {
  if (field.form == FieldForm::kFlag && part == field.name) return part;
  if (field.form == FieldForm::kBits && part.ends_with("bit")) return part;
  if (field.form == FieldForm::kChoice && std::ranges::find(field.choices, part) != field.choices.end()) return part;
  const std::string name = field.word_name() + "=";
  if (part.starts_with(name)) return part.substr(name.size());
  return std::nullopt;
}

void set_optional(const BoardKind& kind, Board& board, std::string_view part, std::vector<std::string>& seen) {
  std::vector<std::string> known;
  for (const BoardField& field : kind.fields) {
    if (field.required) continue;
    known.insert(known.end(), field.choices.begin(), field.choices.end());
    if (field.choices.empty()) known.push_back(field.word_name());
    const auto text = optional_text(field, part);
    if (!text) continue;
    if (std::ranges::find(seen, field.name) != seen.end())
      refuse(fmt::format("\"{}\" sets {} again", part, field.name));
    seen.push_back(field.name);
    field.set(board, value_of(field, *text));
    return;
  }
  const auto near = closest(std::string(part), known);
  refuse(fmt::format("\"{}\" means nothing here{}", part, near ? ", did you mean \"" + *near + "\"" : ""));
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (size_t at = 0;; at += parts.back().size() + 1) {
    parts.push_back(text.substr(at, text.find(separator, at) - at));
    if (at + parts.back().size() >= text.size()) return parts;
  }
}

// columns and rows stand in one part: 9x6.
void set_size(const BoardField& columns, const BoardField& rows, Board& board, std::string_view part) {
  const auto counts = split(part, 'x');
  if (counts.size() != 2) refuse(fmt::format("\"{}\" is not COLUMNSxROWS", part));
  columns.set(board, count_of(counts[0]));
  rows.set(board, count_of(counts[1]));
}

Board parse(const BoardKind& kind, std::string_view fields_text) {
  Board board = kind.empty;
  // A file name may hold colons, so it takes the rest of the word.
  const bool one_file = kind.fields.front().form == FieldForm::kFile;
  const auto parts = one_file ? std::vector{fields_text} : split(fields_text, ':');
  size_t next = 0;
  for (size_t i = 0; i < kind.fields.size(); ++i) {
    const BoardField& field = kind.fields[i];
    if (!field.required) continue;
    if (next >= parts.size() || parts[next].empty()) refuse(fmt::format("{} is missing ({})", field.name, field.help));
    if (field.form == FieldForm::kCount) {
      set_size(field, kind.fields[++i], board, parts[next++]);
    } else {
      field.set(board, value_of(field, parts[next++]));
    }
  }
  std::vector<std::string> seen;
  for (; next < parts.size(); ++next) set_optional(kind, board, parts[next], seen);
  return board;
}

// In millimetres when that reads back to the same double, else in metres, which always does.
std::string length_text(double length_m) {
  for (int decimals = 0; decimals <= 12; ++decimals) {
    std::string text = fmt::format("{:.{}f}mm", length_m * 1000.0, decimals);
    if (length_of(text) == length_m) return text;
  }
  return fmt::format("{}m", length_m);
}

std::string text_of(const BoardField& field, const FieldValue& value) {
  if (field.form == FieldForm::kLength) return length_text(std::get<double>(value));
  if (field.form == FieldForm::kBits) return fmt::format("{}bit", std::get<int>(value));
  if (field.form == FieldForm::kFlag) return field.name;
  return std::visit([](const auto& plain) { return fmt::format("{}", plain); }, value);
}

std::string optional_part_of(const BoardField& field, const FieldValue& value) {
  const bool named = field.form == FieldForm::kLength || field.form == FieldForm::kNumber;
  return (named ? field.word_name() + "=" : "") + text_of(field, value);
}

std::string kinds_in_words() {
  std::string text;
  for (const BoardKind& kind : board_kinds()) text += (text.empty() ? "" : ", ") + kind.name;
  return text;
}

}  // namespace

Board board_from_word(const std::string& word) {
  const std::string name = word.substr(0, word.find(':'));
  if (name.empty())
    refuse("the board's kind is missing; write one of " + kinds_in_words() + ", as chessboard:9x6:25mm");
  const BoardKind& kind = board_kind_named(name);
  Board board;
  try {
    board = parse(kind, name.size() < word.size() ? std::string_view(word).substr(name.size() + 1) : "");
    if (!std::holds_alternative<PointSet>(board)) check(board);
  } catch (const Error& error) {
    refuse(fmt::format("{} is not a board: {}; write {}, as {}", word, error.what(), kind.form(), kind.example));
  }
  load_points(board);
  check(board);
  return board;
}

std::string word_of(const Board& board) {
  const BoardKind& kind = board_kind_of(board);
  std::string word = kind.name;
  for (size_t i = 0; i < kind.fields.size(); ++i) {
    const BoardField& field = kind.fields[i];
    const FieldValue value = field.get(board);
    if (!field.required) {
      if (value != field.get(kind.empty)) word += ":" + optional_part_of(field, value);
      continue;
    }
    const bool second_count = i > 0 && field.form == FieldForm::kCount && kind.fields[i - 1].form == FieldForm::kCount;
    word += (second_count ? "x" : ":") + text_of(field, value);
  }
  return word;
}

}  // namespace raybundle
