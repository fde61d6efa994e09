// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Heavy: for sources that parse TOML anyway; everything else takes board_file.hpp.
#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <vector>

#include "raybundle/targets/board.hpp"

namespace raybundle {

/// The board that a `[target]` table describes: `kind` and the fields of that kind, see board_kinds().
///
/// @param file        name of the file, for messages
/// @param folder      what relative file names are relative to; empty: the working folder
/// @param other_keys  keys of the table that the caller reads itself
/// @throws Error(kBadInput) `file:line: ...` for a missing, unknown or ill-typed field and for a board that cannot be
Board board_from_toml(const toml::table& table, const std::string& file, const std::filesystem::path& folder = {},
                      const std::vector<std::string>& other_keys = {});

}  // namespace raybundle
