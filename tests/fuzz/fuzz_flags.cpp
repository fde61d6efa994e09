// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "dataset.hpp"
#include "fuzz_reader.hpp"
#include "raybundle/io/frame_names.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/scene/wildcard.hpp"

// What stands on the command line: rules, cameras, and the names of files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  const auto each = [&](auto&& read) { fuzz::only_errors(data, size, read); };
  each([](std::string_view text) { apps::rule_from_flag(ParameterRule::Kind::kFixed, std::string(text)); });
  each([](std::string_view text) { apps::rule_from_flag(ParameterRule::Kind::kPrior, std::string(text)); });
  each([](std::string_view text) { apps::anchor_from_flag(std::string(text)); });
  each([](std::string_view text) { apps::camera_from_flag(std::string(text), "pinhole"); });
  each([](std::string_view text) { apps::model_from_name(std::string(text), "here"); });
  each([](std::string_view text) {
    std::vector<std::string> paths;
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      paths.emplace_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
    fuzz::require(frame_names(paths).size() == paths.size(), "one name for each path");
    if (paths.size() > 1 && paths[0].size() < 30) matches_pattern(paths[1], paths[0]);
  });
  return 0;
}
