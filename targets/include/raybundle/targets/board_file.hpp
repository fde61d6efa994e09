// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "raybundle/targets/board.hpp"

namespace raybundle {

/// The `[target]` section that describes a board: what dataset.toml holds and what `raybundle target` writes.
/// A point list's file name is written as it is.
std::string toml_of(const Board& board);

/// Reads a file whose `[target]` section describes a board. Other sections are left to others, so that a dataset.toml
/// can be read too.
///
/// @throws Error(kIo) when the file cannot be read, Error(kBadInput) naming file, line and field
Board read_board_toml(const std::filesystem::path& path);

/// The board of a .toml, or the one that a word describes: what --target takes.
///
/// @throws as read_board_toml() or board_from_word()
Board board_from_word_or_toml(const std::string& word_or_path);

/// The same from a text.
///
/// @param where   name of the text for messages
/// @param folder  what relative file names are relative to; empty: the working folder
Board board_from_toml_text(const std::string& text, const std::string& where, const std::filesystem::path& folder = {});

/// Writes toml_of(board) with a comment that shows its use, whole or not at all.
///
/// @throws Error(kIo) naming the path
void write_board_toml(const Board& board, const std::filesystem::path& path);

}  // namespace raybundle
