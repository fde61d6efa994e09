// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "given_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "raybundle/bundle/parameters.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/parameter_names.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

// What is kept without a value has that of the start: boards keep their shape, too, and what corners contradict can be
// named.
//
// @param places_known  whether the start knows the first camera, as seen from which it then has the others
void keep_at_start(const Calibration& start, bool places_known, CalibrationProblem& problem) {
  const std::map<std::string, double> at_start = parameter_values(start);
  std::vector<ParameterRule> values;
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    const bool is_place = block.kind == ParameterBlock::Kind::kCameraFromRig;
    if (is_place && block.owner == 0) continue;
    for (const Parameter& parameter : block.parameters) {
      if (parameter.kind == ParameterRule::Kind::kFree || parameter.value) continue;
      const auto value = at_start.find(parameter.name);
      const bool known = value != at_start.end() && (places_known || !is_place);
      if (!known && block.kind != ParameterBlock::Kind::kShape) {
        throw Error(
            ErrorKind::kBadInput,
            fmt::format("'{0}' is to be kept, but the file of --start does not say at which value; write {0}=VALUE",
                        parameter.name));
      }
      // A board that the start does not know is flat.
      values.push_back({parameter.name, parameter.kind, known ? value->second : 0.0, parameter.sigma});
    }
  }
  std::erase_if(problem.rules,
                [](const ParameterRule& rule) { return rule.kind != ParameterRule::Kind::kFree && !rule.value; });
  std::ranges::move(values, std::back_inserter(problem.rules));
}

// Null when the start does not have it.
const RigCamera* find_camera(const Calibration& start, const std::string& name) {
  const auto found = std::ranges::find(start.cameras, name, &RigCamera::name);
  return found == start.cameras.end() ? nullptr : &*found;
}

// The rig frame of a solve is that of its first camera, which may be another one than the start's.
void refer_to(const Rigid3& first_from_rig, Calibration& start) {
  for (RigCamera& camera : start.cameras) camera.camera_from_rig = camera.camera_from_rig * first_from_rig.inverse();
}

// Whether the parameters are the same for the solve.
bool same(const std::vector<ParameterBlock>& a, const std::vector<ParameterBlock>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    for (std::size_t i = 0; i < a[k].parameters.size(); ++i) {
      const Parameter &one = a[k].parameters[i], &other = b[k].parameters[i];
      if (one.kind != other.kind || one.value != other.value || one.sigma != other.sigma) return false;
    }
  }
  return true;
}

}  // namespace

void take_start(const std::string& path, CalibrationProblem& problem) {
  Calibration start = read_calibration(path).calibration;
  const auto in_start = [&](const ProblemCamera& camera) { return find_camera(start, camera.name) != nullptr; };
  if (std::ranges::none_of(problem.cameras, in_start)) camera_named(start, problem.cameras.front().name);  // says so
  const RigCamera* first = find_camera(start, problem.cameras.front().name);
  if (first != nullptr) refer_to(Rigid3(first->camera_from_rig), start);
  for (ProblemCamera& camera : problem.cameras) {
    const RigCamera* found = find_camera(start, camera.name);
    if (found == nullptr) {
      say_warning(fmt::format("camera {} is not in {}: it starts from its images alone", camera.name, path));
      continue;
    }
    const RigCamera& known = *found;
    if (known.camera.model != camera.model) {
      throw Error(ErrorKind::kBadInput, fmt::format("camera {} is a {} in {}, but --model says {}", camera.name,
                                                    model_name(known.camera.model), path, model_name(camera.model)));
    }
    if (known.camera.size != camera.size) {
      throw Error(ErrorKind::kBadInput,
                  fmt::format("camera {} has {}x{} images, but {}x{} in {}; start from a calibration of images of the "
                              "same size",
                              camera.name, camera.size.width, camera.size.height, known.camera.size.width,
                              known.camera.size.height, path));
    }
    camera.parameters = known.camera.parameters;
    if (first != nullptr) camera.camera_from_rig = known.camera_from_rig;
  }
  keep_at_start(start, first != nullptr, problem);
}

void warn_of_void_rules(const CalibrationProblem& problem) {
  const std::vector<ParameterBlock> blocks = parameter_blocks(problem);
  for (std::size_t i = 0; i < problem.rules.size(); ++i) {
    const ParameterRule& rule = problem.rules[i];
    CalibrationProblem without;
    without.cameras = problem.cameras;
    without.targets = problem.targets;
    without.rules = problem.rules;
    without.rules.erase(without.rules.begin() + static_cast<std::ptrdiff_t>(i));
    if (rule.kind == ParameterRule::Kind::kFree || !same(blocks, parameter_blocks(without))) continue;
    say_warning(
        fmt::format("the {} '{}' is without effect: another rule says the same or overrides it (--prior overrides "
                    "--free, and that --fix), or it is the place of the first camera, which defines the rig",
                    rule.kind == ParameterRule::Kind::kPrior ? "prior on" : "value kept for", rule.pattern));
  }
}

}  // namespace raybundle::apps
