// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/cross_validation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "rig_worlds.hpp"

namespace raybundle {
namespace {

using testing::stereo;
using testing::synthetic_world;
using testing::SyntheticOptions;
using Verdict = CrossValidation::Verdict;

CrossValidation validated(const CalibrationProblem& problem) { return cross_validate(problem, calibrate(problem), {}); }

TEST(CrossValidation, HalvesOfOneWorldAgree) {
  SyntheticOptions options = stereo(3);
  options.noise_px = 0.1;
  EXPECT_EQ(validated(synthetic_world(options).problem).verdict, Verdict::kAgree);
}

// Of twelve views of the right camera only two are in even frames: nothing tests it.
TEST(CrossValidation, ACameraThatAHalfCannotCalibrateIsNamed) {
  SyntheticOptions options = stereo(3);
  options.noise_px = 0.1;
  CalibrationProblem problem = synthetic_world(options).problem;
  std::set<int> frames_of_left;
  for (const TargetView& view : problem.views) {
    if (view.camera == 0) frames_of_left.insert(view.frame);
  }
  int even = 0;
  std::erase_if(problem.views, [&](const TargetView& view) {
    if (view.camera == 0) return false;
    const auto rank = std::distance(frames_of_left.begin(), frames_of_left.lower_bound(view.frame));
    return !frames_of_left.contains(view.frame) || (rank % 2 == 1 && ++even > 2);
  });
  const CrossValidation found = validated(problem);
  EXPECT_EQ(found.verdict, Verdict::kTooFewFrames);
  EXPECT_THAT(found.words, ::testing::StartsWith("camera camera1 could not be calibrated from the odd and from"));
}

// A lens that is held at its start is held in the halves, too.
TEST(CrossValidation, RulesThatKeepTheStartHold) {
  SyntheticOptions options = stereo(3);
  options.noise_px = 0.1;
  testing::SyntheticWorld world = synthetic_world(options);
  for (std::size_t c = 0; c < 2; ++c) world.problem.cameras[c].parameters = world.cameras[c].parameters;
  world.problem.cameras[1].parameters->head<2>() *= 1.01;
  world.problem.rules = {{"camera1.fx", ParameterRule::Kind::kFixed, {}, 0.0},
                         {"camera1.fy", ParameterRule::Kind::kFixed, {}, 0.0}};
  for (const ModelTrial& trial : validated(world.problem).trials) EXPECT_GT(trial.rms_px, 0.0) << trial.model;
}

}  // namespace
}  // namespace raybundle
