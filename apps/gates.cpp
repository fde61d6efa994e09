// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "gates.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle::apps {
namespace {

std::string place_of(const std::string& path, const toml::node& node) {
  return fmt::format("{}:{}", path, node.source().begin.line);
}

std::vector<Requirement> requirements_in(const std::string& path) {
  const std::string text = text_of_file(path);
  toml::table table;
  try {
    table = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw Error(ErrorKind::kBadInput, std::string(error.description()),
                fmt::format("{}:{}", path, error.source().begin.line));
  }
  for (const auto& [key, value] : table) {
    if (key.str() == "require") continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("unknown key '{}'.{}", key.str(), did_you_mean(std::string(key.str()), {"require"})),
                place_of(path, value));
  }
  const toml::array* list = table["require"].as_array();
  if (list == nullptr || list->empty()) {
    throw Error(ErrorKind::kBadInput, "it requires nothing; write require = [\"projection 0.2 px over 110 deg\"]",
                path);
  }
  std::vector<Requirement> requirements;
  for (const toml::node& entry : *list) {
    const auto words = entry.value<std::string>();
    if (!words) throw Error(ErrorKind::kBadInput, "a requirement is a text in quotes", place_of(path, entry));
    try {
      requirements.push_back(requirement_from_text(*words));
    } catch (const Error& error) {
      throw Error(error.kind(), error.what(), place_of(path, entry));
    }
  }
  return requirements;
}

}  // namespace

void add_gate_flags(CLI::App& verb, GateFlags& flags) {
  verb.add_option("--require", flags.require,
                  "what the calibration has to reach, or exit code 1: " + requirement_help())
      ->type_name("WORDS")
      ->allow_extra_args(false);
  verb.add_option("--gates", flags.file, "TOML file with more of them: require = [\"...\", \"...\"]")
      ->type_name("FILE");
}

std::vector<Requirement> requirements_of(const GateFlags& flags) {
  std::vector<Requirement> requirements;
  for (const std::string& words : flags.require) requirements.push_back(requirement_from_text(words));
  if (flags.file.empty()) return requirements;
  std::ranges::move(requirements_in(flags.file), std::back_inserter(requirements));
  return requirements;
}

void check_requirements(const std::vector<Requirement>& requirements, const std::vector<std::string>& cameras,
                        bool with_laser) {
  for (const Requirement& requirement : requirements) {
    const std::string& camera = requirement.camera;
    if (!camera.empty() && std::ranges::find(cameras, camera) == cameras.end()) {
      throw Error(ErrorKind::kBadInput, fmt::format("'{}': there is no camera '{}'.{}", requirement.text, camera,
                                                    did_you_mean(camera, cameras)));
    }
    const bool depth = requirement.quantity == Quantity::kDepth;
    if (cameras.size() > 1 || (depth && with_laser)) continue;
    if (!depth && requirement.quantity != Quantity::kBaseline) continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("'{}': one camera without a laser has no baseline and tells no depth; require it of a rig, "
                            "or require a projection",
                            requirement.text));
  }
}

}  // namespace raybundle::apps
