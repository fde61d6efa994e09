// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "raybundle/targets/board.hpp"

namespace raybundle {

/// What a field of a board holds, and with that how words and files spell it.
enum class FieldForm {
  kCount,   ///< int; columns and rows stand together in a word: 9x6
  kLength,  ///< double [m]; in a word with its unit: 25mm; optional ones as row_step=35mm
  kNumber,  ///< int; optional ones stand in a word as first_tag=24
  kRatio,   ///< double without unit
  kBits,    ///< int; in a word 1bit
  kChoice,  ///< one of a list of names
  kFlag,    ///< bool; in a word its name, when true
  kFile,    ///< path; relative ones are relative to the TOML file, or to the working folder in a word
};

using FieldValue = std::variant<int, double, bool, std::string>;

/// One field of a kind of board: word grammar, TOML files and help all walk these.
struct BoardField {
  std::string name;  ///< the TOML key
  FieldForm form;
  bool required;
  std::string help;                  ///< one clause, with the unit
  std::vector<std::string> choices;  ///< of kChoice
  std::function<FieldValue(const Board&)> get;
  std::function<void(Board&, const FieldValue&)> set;  ///< the value's type must be the form's

  std::string word_name() const;  ///< the name without the unit: square for square_m
};

/// One kind of board.
struct BoardKind {
  std::string name;     ///< chessboard, ...: what stands in TOML under `kind` and begins a word
  std::string help;     ///< one clause
  std::string example;  ///< a word of this kind
  Board empty;          ///< with the defaults of the optional fields
  std::vector<BoardField> fields;

  /// The grammar of its words: charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY[:legacy][:inverted]
  std::string form() const;
};

/// All kinds, in the order of the Board variant.
const std::vector<BoardKind>& board_kinds();

/// The kind of a board.
const BoardKind& board_kind_of(const Board& board);

/// The kind of that name. Throws Error(kBadInput) with a suggestion when there is none.
const BoardKind& board_kind_named(const std::string& name);

}  // namespace raybundle
