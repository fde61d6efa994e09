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
void keep_at_start(const Calibration& start, CalibrationProblem& problem) {
  const std::map<std::string, double> at_start = parameter_values(start);
  std::vector<ParameterRule> values;
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    if (block.kind == ParameterBlock::Kind::kCameraFromRig && block.owner == 0) continue;
    for (const Parameter& parameter : block.parameters) {
      if (parameter.kind == ParameterRule::Kind::kFree || parameter.value) continue;
      const auto value = at_start.find(parameter.name);  // none of a board that the start does not know, which is flat
      values.push_back(
          {parameter.name, parameter.kind, value == at_start.end() ? 0.0 : value->second, parameter.sigma});
    }
  }
  std::erase_if(problem.rules,
                [](const ParameterRule& rule) { return rule.kind != ParameterRule::Kind::kFree && !rule.value; });
  std::ranges::move(values, std::back_inserter(problem.rules));
}

// The rig frame of a solve is that of its first camera, which may be another one than the start's.
void refer_to_first_camera(const CalibrationProblem& problem, Calibration& start) {
  const Rigid3 rig_from_first = camera_named(start, problem.cameras.front().name).camera_from_rig.inverse();
  for (RigCamera& camera : start.cameras) camera.camera_from_rig = camera.camera_from_rig * rig_from_first;
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
  refer_to_first_camera(problem, start);
  for (ProblemCamera& camera : problem.cameras) {
    const RigCamera& known = camera_named(start, camera.name);
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
    camera.camera_from_rig = known.camera_from_rig;
  }
  keep_at_start(start, problem);
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
