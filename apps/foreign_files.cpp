// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "foreign_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOwnFormat = "\"raybundle calibration\"";

// Files of a folder that may be of a format here, in the order of their names; images and the like are not read.
std::vector<std::string> files_of(const fs::path& folder) {
  constexpr std::array kEndings{".yaml", ".yml", ".json", ".txt", ".cameramodel"};
  constexpr std::uintmax_t kMostBytes = 100'000'000;
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code unreadable;
    const bool small = entry->is_regular_file(unreadable) && entry->file_size(unreadable) <= kMostBytes;
    if (small && std::ranges::find(kEndings, entry->path().extension()) != kEndings.end()) {
      files.push_back(entry->path().string());
    }
  }
  if (error) throw Error(ErrorKind::kIo, "cannot be read: " + error.message(), folder.string());
  std::ranges::sort(files);
  return files;
}

const ForeignFormat& format_of(const std::vector<NamedText>& files) {
  for (const NamedText& file : files) {
    for (const ForeignFormat& format : foreign_formats()) {
      if (format.recognises(file.text)) return format;
    }
  }
  if (files[0].text.find(kOwnFormat) != std::string::npos) {
    throw Error(ErrorKind::kBadInput, "is a calibration.json already; nothing is to be done", files[0].name);
  }
  throw Error(ErrorKind::kBadInput,
              "looks like no format that is known here; say which with --from, one of " +
                  fmt::format("{}", fmt::join(format_names(), ", ")),
              files[0].name);
}

}  // namespace

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  for (const ForeignFormat& format : foreign_formats()) names.emplace_back(format.name);
  return names;
}

std::string formats_help() {
  std::vector<std::string> texts;
  for (const ForeignFormat& format : foreign_formats())
    texts.push_back(fmt::format("{} ({})", format.name, format.what));
  return fmt::format("{}", fmt::join(texts, ", "));
}

void require_lens(const ForeignFormat& format, const std::string& lens) {
  std::vector<std::string> names;
  for (const ForeignLens& known : format.lenses) names.emplace_back(known.name);
  if (lens.empty() || std::ranges::find(names, lens) != names.end()) return;
  throw Error(ErrorKind::kBadInput,
              fmt::format("{} has no lens {}.{}", format.name, in_quotes(lens), did_you_mean(lens, names)), "--lens");
}

void require_other_file(const std::vector<std::string>& inputs, const std::string& output) {
  for (const std::string& input : inputs) {
    std::error_code not_there;
    if (fs::equivalent(input, output, not_there)) {
      throw Error(ErrorKind::kBadInput, "is read, and would be written over; choose another output", input);
    }
  }
}

ForeignFiles read_foreign_files(const std::vector<std::string>& paths, const std::string& from) {
  std::error_code ignored;
  const bool folder = paths.size() == 1 && fs::is_directory(paths[0], ignored);
  ForeignFiles read;
  for (const std::string& path : folder ? files_of(paths[0]) : paths) read.files.push_back({path, text_of_file(path)});
  if (read.files.empty())
    throw Error(ErrorKind::kBadInput, "the folder has no file of a format that is known here", paths[0]);
  read.format = from.empty() ? &format_of(read.files) : foreign_format_named(from);
  if (folder) {
    std::erase_if(read.files, [&](const NamedText& file) { return !read.format->recognises(file.text); });
    if (read.files.empty()) {
      throw Error(ErrorKind::kBadInput, fmt::format("no file looks like {}", read.format->what), paths[0]);
    }
  }
  return read;
}

}  // namespace raybundle::apps
