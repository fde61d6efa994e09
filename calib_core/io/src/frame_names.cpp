// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/frame_names.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace raybundle {
namespace {

// The runs of digits of a text, without leading zeros.
std::vector<std::string> digit_runs(const std::string& text) {
  std::vector<std::string> runs;
  bool inside = false;
  for (const char c : text) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (digit && !inside) runs.emplace_back();
    if (digit && runs.back() == "0") runs.back().clear();
    if (digit) runs.back() += c;
    inside = digit;
  }
  return runs;
}

std::string stem(const std::string& path) { return std::filesystem::path(path).stem().string(); }

// Which runs differ among the names; empty when the names have different numbers of runs, or nothing differs.
std::vector<std::size_t> differing_runs(const std::vector<std::vector<std::string>>& runs) {
  std::vector<std::size_t> differing;
  for (const auto& of_name : runs) {
    if (of_name.size() != runs.front().size()) return {};
  }
  for (std::size_t k = 0; k < runs.front().size(); ++k) {
    const auto same = [&](const auto& of_name) { return of_name[k] == runs.front()[k]; };
    if (!std::ranges::all_of(runs, same)) differing.push_back(k);
  }
  return differing;
}

}  // namespace

std::vector<std::string> frame_names(const std::vector<std::string>& paths) {
  if (paths.empty()) return {};
  std::vector<std::vector<std::string>> runs;
  for (const std::string& path : paths) runs.push_back(digit_runs(stem(path)));
  std::vector<std::size_t> chosen = differing_runs(runs);
  if (chosen.empty() && paths.size() > 1) {  // folders may tell the frames apart: 01/left.png, 02/left.png
    std::vector<std::vector<std::string>> of_paths;
    for (const std::string& path : paths) of_paths.push_back(digit_runs(path));
    chosen = differing_runs(of_paths);
    if (!chosen.empty()) runs = of_paths;
  }
  if (chosen.empty() && paths.size() == 1 && !runs.front().empty()) chosen = {runs.front().size() - 1};

  std::vector<std::string> names;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    std::string name;
    for (const std::size_t k : chosen) name += (name.empty() ? "" : "-") + runs[i][k];
    names.push_back(chosen.empty() ? stem(paths[i]) : name);
  }
  return names;
}

bool numbered_apart(const std::string& path_a, const std::string& path_b) {
  const std::vector<std::string> a = digit_runs(stem(path_a)), b = digit_runs(stem(path_b));
  return !a.empty() && !b.empty() && std::ranges::find_first_of(a, b) == a.end();
}

}  // namespace raybundle
