// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raybundle/scene/atomic_file.hpp"

namespace raybundle::apps {

/// Finds out before the work, not after it, whether a folder can be written or made. Nothing is made yet, so that a run
/// that fails leaves nothing behind.
///
/// @throws Error(kIo) naming the folder
void require_writable(const std::filesystem::path& folder);

/// The same of a file, whose folder has to be there.
///
/// @param flag  that named it
/// @throws Error(kIo) naming the file
void require_writable_file(const std::filesystem::path& file, const std::string& flag);

/// Writes files into a folder, all of them or none, and makes the folder where it is not there yet. When the writing
/// fails, folders that were made for it are removed again.
///
/// @param files  their paths lie in `folder`
/// @throws Error(kIo) naming the folder or file
void write_results(const std::filesystem::path& folder, const std::vector<WholeFile>& files);

}  // namespace raybundle::apps
