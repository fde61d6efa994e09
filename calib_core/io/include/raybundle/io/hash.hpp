// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace raybundle {

/// SHA-256 of the bytes, 64 lower-case hexadecimal digits.
std::string sha256_of_bytes(std::string_view bytes);

/// SHA-256 of a file's content, read piece by piece.
///
/// @throws Error(kIo) when the file cannot be read
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace raybundle
