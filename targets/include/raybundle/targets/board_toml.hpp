// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Heavy: for sources that parse TOML anyway; everything else takes board_file.hpp.
#include <filesystem>

#include "raybundle/targets/board.hpp"
#include "raybundle/toml/toml_reader.hpp"

namespace raybundle {

/// The board that a `[target]` table describes: `kind` and the fields of that kind, see board_kinds().
///
/// @param reader      of the table; keys that the caller has asked it for are the caller's
/// @param folder      what relative file names are relative to; empty: the working folder
/// @throws Error(kBadInput) `file:line: ...` for a missing, unknown or ill-typed field and for a board that cannot be
Board board_from_toml(TomlReader& reader, const std::filesystem::path& folder = {});

}  // namespace raybundle
