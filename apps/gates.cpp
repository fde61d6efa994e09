// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "gates.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/toml/toml_reader.hpp"

namespace raybundle::apps {
namespace {

std::vector<Requirement> requirements_in(const std::string& path) {
  const toml::table table = toml_from_text(text_of_file(path), path);
  TomlReader reader(table, "the file", path);
  const toml::node* list = reader.get("require");
  reader.refuse_unknown_keys();
  if (list == nullptr || !list->is_array() || list->as_array()->empty()) {
    reader.fail(list, "it requires nothing; write require = [\"projection 0.2 px over 110 deg\"]");
  }
  std::vector<Requirement> requirements;
  for (const toml::node& entry : *list->as_array()) {
    const auto words = entry.value<std::string>();
    if (!words) reader.fail(&entry, "a requirement is a text in quotes");
    try {
      requirements.push_back(requirement_from_text(*words));
    } catch (const Error& error) {
      throw Error(error.kind(), error.what(), reader.place(entry));
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
