// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

namespace raybundle {

/// Writes a file whole or not at all: an old file is never lost to a failed run, and no reader sees half a file.
///
/// The bytes go to a temporary name in the same folder, are flushed to the disk, and the name is changed last. A path
/// that exists and is no regular file (/dev/stdout, a pipe) is written to as it is.
///
/// @throws Error(kIo) naming the path; the temporary file is removed
void write_file_whole(const std::filesystem::path& path, std::string_view bytes);

/// A file that is to be written.
struct WholeFile {
  WholeFile(std::filesystem::path file, std::string_view bytes) : path(std::move(file)), pieces{bytes} {}
  WholeFile(std::filesystem::path file, std::vector<std::string_view> bytes)
      : path(std::move(file)), pieces(std::move(bytes)) {}

  std::filesystem::path path;
  std::vector<std::string_view> pieces;  ///< one behind the other, of the caller, who keeps them
};

/// Writes files that belong together: none of them changes its name before all of them lie whole on the disk, so that
/// a full disk leaves all of the old ones.
///
/// @throws Error(kIo) as write_file_whole
void write_files_whole(const std::vector<WholeFile>& files);

}  // namespace raybundle
