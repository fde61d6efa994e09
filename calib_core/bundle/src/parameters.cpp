// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/parameters.hpp"

#include <algorithm>
#include <string_view>

#include "dot_rows.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/parameter_names.hpp"
#include "raybundle/scene/wildcard.hpp"

namespace raybundle {
namespace {

using RuleKind = ParameterRule::Kind;

constexpr double kSmallestPriorSigma = 1e-12;  // whatever the unit: sums of squares still tell it from nothing

ParameterBlock make_block(ParameterBlock::Kind kind, int owner, std::string group,
                          const std::vector<std::string>& names) {
  ParameterBlock block{kind, owner, std::move(group), {}};
  for (const std::string& name : names) block.parameters.push_back({.name = name, .value = {}});
  return block;
}

void fix_all(ParameterBlock& block) {
  for (Parameter& parameter : block.parameters) parameter.kind = RuleKind::kFixed;
}

[[noreturn]] void throw_no_match(const ParameterRule& rule, const std::vector<ParameterBlock>& blocks) {
  std::string known;
  for (const ParameterBlock& block : blocks) {
    known += (known.empty() ? "" : ", ") + block.group;
    for (const Parameter& parameter : block.parameters) known += ", " + parameter.name;
  }
  throw Error(ErrorKind::kBadInput, "no parameter matches '" + rule.pattern + "'; there are: " + known);
}

bool speaks_of(const ParameterRule& rule, const ParameterBlock& block, const Parameter& parameter) {
  return matches_pattern(block.group, rule.pattern) || matches_pattern(parameter.name, rule.pattern);
}

// A focal length of zero or less projects nothing, and the solve would break down over it.
void require_focal_length(const ParameterRule& rule, const ParameterBlock& block, std::size_t index) {
  const bool focal = block.kind == ParameterBlock::Kind::kIntrinsics && index < 2;  // fx, fy
  if (!focal || !rule.value || *rule.value > 0.0) return;
  throw Error(ErrorKind::kBadInput, "'" + rule.pattern + "' sets " + block.parameters[index].name +
                                        ", a focal length, to zero or less; give the focal length in pixels");
}

// Centres, focal lengths and coefficients have no value in common, but nothing.
void refuse_value_of_group(const ParameterRule& rule, const ParameterBlock& block) {
  const bool of_group = block.kind != ParameterBlock::Kind::kShape && matches_pattern(block.group, rule.pattern);
  if (!of_group || rule.value.value_or(0.0) == 0.0) return;
  throw Error(ErrorKind::kBadInput, "'" + rule.pattern + "' names all of " + block.group +
                                        ", which cannot have one value; name one, as " + block.parameters[0].name);
}

void apply_rule(const ParameterRule& rule, std::vector<ParameterBlock>& blocks) {
  if (rule.kind == RuleKind::kPrior && !(rule.sigma > 0.0)) {
    throw Error(ErrorKind::kBadInput, "the prior on '" + rule.pattern + "' needs a sigma above zero");
  }
  if (rule.kind == RuleKind::kPrior && rule.sigma < kSmallestPriorSigma) {
    throw Error(ErrorKind::kBadInput,
                "the prior on '" + rule.pattern +
                    "' has a sigma below what rounding leaves; to keep its value, fix it instead");
  }
  bool matched = false;
  for (ParameterBlock& block : blocks) {
    for (std::size_t i = 0; i < block.parameters.size(); ++i) {
      Parameter& parameter = block.parameters[i];
      if (!speaks_of(rule, block, parameter)) continue;
      refuse_value_of_group(rule, block);
      require_focal_length(rule, block, i);
      parameter.kind = rule.kind;
      parameter.value = rule.kind == RuleKind::kFree ? std::nullopt : rule.value;
      parameter.sigma = rule.sigma;
      matched = true;
    }
  }
  if (!matched) throw_no_match(rule, blocks);
}

// All blocks, without a word of the rules.
std::vector<ParameterBlock> free_blocks(const CalibrationProblem& problem) {
  std::vector<ParameterBlock> blocks;
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    const std::string& name = problem.cameras[c].name;
    blocks.push_back(make_block(ParameterBlock::Kind::kIntrinsics, c, name + ".intrinsics",
                                intrinsic_names(name, problem.cameras[c].model)));
    blocks.push_back(
        make_block(ParameterBlock::Kind::kCameraFromRig, c, name + ".camera_from_rig", extrinsic_names(name)));
  }
  for (int t = 0; t < static_cast<int>(problem.targets.size()); ++t) {
    const std::string& name = problem.targets[t].name;
    blocks.push_back(make_block(ParameterBlock::Kind::kShape, t, name + ".shape", shape_names(name)));
  }
  return blocks;
}

bool has_dot(const CalibrationProblem& problem, const BundleState& state, int view) {
  for (int i = 0; i < static_cast<int>(problem.views[view].dots.size()); ++i) {
    if (in_use(problem, state, view, i)) return true;
  }
  return false;
}

// Whether a used corner or dot depends on each camera and each target.
struct Seen {
  std::vector<bool> cameras, targets;

  Seen(const CalibrationProblem& problem, const BundleState& state)
      : cameras(problem.cameras.size(), false), targets(problem.targets.size(), false) {
    for (std::size_t v = 0; v < problem.views.size(); ++v) {
      if (state.pose_of_view[v] < 0) continue;
      const bool has_corner = std::ranges::find(state.fates[v], ObservationFate::kUsed) != state.fates[v].end();
      if (!has_corner && !has_dot(problem, state, static_cast<int>(v))) continue;
      cameras[problem.views[v].camera] = true;
      targets[problem.views[v].target] = true;
    }
  }
};

}  // namespace

std::vector<int> ParameterBlock::free() const {
  std::vector<int> indices;
  for (int i = 0; i < static_cast<int>(parameters.size()); ++i) {
    if (parameters[i].kind != RuleKind::kFixed) indices.push_back(i);
  }
  return indices;
}

std::vector<int> ParameterBlock::with_prior() const {
  std::vector<int> indices;
  for (int i = 0; i < static_cast<int>(parameters.size()); ++i) {
    if (parameters[i].kind == RuleKind::kPrior) indices.push_back(i);
  }
  return indices;
}

std::vector<ParameterBlock> parameter_blocks(const CalibrationProblem& problem) {
  std::vector<ParameterBlock> blocks = free_blocks(problem);
  for (const ParameterRule& rule : problem.lens_priors) apply_rule(rule, blocks);
  for (const ParameterRule& rule : problem.rules) apply_rule(rule, blocks);
  for (ParameterBlock& block : blocks) {
    if (block.kind != ParameterBlock::Kind::kCameraFromRig || block.owner != 0) continue;
    for (Parameter& parameter : block.parameters)
      parameter = {.name = parameter.name, .kind = RuleKind::kFixed, .value = {}};
  }
  return blocks;
}

bool matches_any(const ParameterRule& rule, const CalibrationProblem& problem) {
  return std::ranges::any_of(free_blocks(problem), [&](const ParameterBlock& block) {
    return std::ranges::any_of(block.parameters,
                               [&](const Parameter& parameter) { return speaks_of(rule, block, parameter); });
  });
}

std::vector<ParameterBlock> estimated_blocks(const CalibrationProblem& problem, const BundleState& state,
                                             const BundleOptions& options) {
  std::vector<ParameterBlock> blocks = parameter_blocks(problem);
  const Seen seen(problem, state);
  for (ParameterBlock& block : blocks) {
    const bool is_shape = block.kind == ParameterBlock::Kind::kShape;
    const bool possible =
        is_shape ? seen.targets[block.owner] && options.estimate_shape && problem.targets[block.owner].flat()
                 : seen.cameras[block.owner];
    if (!possible) fix_all(block);
  }
  return blocks;
}

}  // namespace raybundle
