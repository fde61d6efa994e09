// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/io/foreign_format.hpp"

namespace raybundle::apps {

/// Names of all formats, for flags.
std::vector<std::string> format_names();

/// opencv (what its files are), ros (...), ...
std::string formats_help();

/// @throws Error(kBadInput) that lists the lenses, unless the name is empty or one of the format's
void require_lens(const ForeignFormat& format, const std::string& lens);

/// @throws Error(kBadInput) when what is to be written is one of the files that are read
void require_other_file(const std::vector<std::string>& inputs, const std::string& output);

/// Files of another program, read.
struct ForeignFiles {
  const ForeignFormat* format = nullptr;
  std::vector<NamedText> files;
};

/// Reads files and tells their format by what is in them.
///
/// @param paths  files, or a folder, of which the files of the format are taken in the order of their names
/// @param from   name of the format; empty: what the first file looks like
/// @throws Error(kIo) when one cannot be read; Error(kBadInput) when no format is told
ForeignFiles read_foreign_files(const std::vector<std::string>& paths, const std::string& from);

}  // namespace raybundle::apps
