// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "former_frames.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "terminal.hpp"

namespace raybundle::apps {

namespace fs = std::filesystem;

void remove_former_frames(const fs::path& folder, const PointsFormat& format, std::span<const char* const> endings,
                          const std::set<std::string>& names) {
  std::vector<std::string> former;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() != ".json" || !entry.is_regular_file() || names.contains(name)) continue;
    std::ifstream file(entry.path());
    const auto json = nlohmann::json::parse(file, nullptr, false);
    if (json.is_object() && json.contains("format") && json["format"] == format.name) former.push_back(name);
  }
  for (const std::string& name : former) {
    for (const char* ending : endings) fs::remove(folder / (name + ending));
  }
  if (!former.empty()) {
    say(fmt::format("removed {} frame{} of a former run from {}", former.size(), former.size() == 1 ? "" : "s",
                    folder.string()));
  }
}

}  // namespace raybundle::apps
