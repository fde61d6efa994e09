// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "output_folder.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& folder, const std::string& why) {
  throw Error(ErrorKind::kIo,
              fmt::format("the output folder {} cannot be {}; choose another with -o", folder.string(), why));
}

// Folders that making `folder` would make, the innermost first.
std::vector<fs::path> missing_folders(const fs::path& folder) {
  std::vector<fs::path> missing;
  std::error_code ignored;
  for (fs::path at = folder; !at.empty() && !fs::exists(at, ignored); at = at.parent_path()) {
    missing.push_back(at);
    if (at == at.parent_path()) break;
  }
  return missing;
}

}  // namespace

void require_writable(const fs::path& folder) {
  if (folder.empty()) throw Error(ErrorKind::kBadInput, "the output folder has no name; give one with -o, as -o out");
  const std::vector<fs::path> missing = missing_folders(folder);
  const fs::path parent = missing.empty() ? folder : missing.back().parent_path();
  const fs::path existing = parent.empty() ? fs::path(".") : parent;
  const char* verb = missing.empty() ? "written" : "made";
  std::error_code ignored;
  if (!fs::is_directory(existing, ignored)) {
    refuse(folder, fmt::format("{}: {} is no folder", verb, existing.string()));
  }
  if (::access(existing.c_str(), W_OK | X_OK) != 0) {
    refuse(folder, fmt::format("{}: {}", verb, std::strerror(errno)));
  }
}

void require_writable_file(const fs::path& file, const std::string& flag) {
  std::error_code ignored;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::kIo, fmt::format("cannot be written: {}; choose another with {}", why, flag), file.string());
  };
  if (fs::is_directory(file, ignored)) refuse("it is a folder");
  if (!fs::is_directory(folder, ignored)) refuse("there is no folder " + folder.string());
  if (fs::exists(file, ignored) && !fs::is_regular_file(file, ignored)) return;  // a pipe, /dev/stdout
  if (::access(folder.c_str(), W_OK | X_OK) != 0) refuse(std::strerror(errno));
}

void write_results(const fs::path& folder, const std::vector<WholeFile>& files) {
  const std::vector<fs::path> made = missing_folders(folder);
  try {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) refuse(folder, "made: " + error.message());
    write_files_whole(files);
  } catch (...) {
    std::error_code ignored;
    for (const fs::path& each : made) fs::remove(each, ignored);  // one that holds something stays
    throw;
  }
}

}  // namespace raybundle::apps
