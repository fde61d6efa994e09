// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace raybundle {

/// Writes a file whole or not at all: an old file is never lost to a failed run, and no reader sees half a file.
///
/// The bytes go to a temporary name in the same folder, are flushed to the disk, and the name is changed last. A path
/// that exists and is no regular file (/dev/stdout, a pipe) is written to as it is.
///
/// @throws Error(kIo) naming the path; the temporary file is removed
void write_file_whole(const std::filesystem::path& path, std::string_view bytes);

}  // namespace raybundle
