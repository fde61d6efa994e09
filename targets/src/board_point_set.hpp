// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "raybundle/targets/board.hpp"

namespace raybundle {

/// Reads the points of a PointSet from its file; other boards are left as they are.
///
/// @param folder  what a relative file name is relative to; empty: the working folder
/// @throws Error(kIo) when the file cannot be read, Error(kBadInput) naming the line that is wrong
void load_points(Board& board, const std::filesystem::path& folder = {});

}  // namespace raybundle
