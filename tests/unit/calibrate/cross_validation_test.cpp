// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/cross_validation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "draw.hpp"
#include "rig_worlds.hpp"

namespace raybundle {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::Field;
using ::testing::HasSubstr;
using testing::stereo;
using testing::synthetic_world;
using testing::SyntheticOptions;
using Verdict = CrossValidation::Verdict;

CrossValidation validated(const CalibrationProblem& problem, const CalibrateOptions& options = {}) {
  return cross_validate(problem, calibrate(problem, options), options);
}

// A camera whose boards keep within 50 degrees of its axis.
SyntheticOptions narrow(const char* model, const std::vector<double>& shape) {
  SyntheticOptions options;
  options.cameras[0].model = model;
  options.cameras[0].focal_px = 1000.0;
  options.cameras[0].shape = shape;
  options.frames = 24;
  options.noise_px = 0.1;
  options.max_off_axis_rad = 0.4;
  return options;
}

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

// A lens that is held at a wrong start is held in the halves, too, which therefore disagree; the start says nothing of
// other models.
TEST(CrossValidation, RulesThatKeepTheStartHold) {
  testing::SyntheticWorld world = synthetic_world(narrow("brown_conrady", {-0.25, 0.1, 0.0, 0.0, 0.0}));
  world.problem.cameras[0].parameters = world.cameras[0].parameters;
  (*world.problem.cameras[0].parameters)[4] = 0.0;
  world.problem.rules = {{"camera0.k?", ParameterRule::Kind::kFixed, {}, 0.0},
                         {"camera0.p?", ParameterRule::Kind::kFixed, {}, 0.0}};
  const CrossValidation found = validated(world.problem);
  const std::vector<ModelTrial>& trials = found.trials;
  EXPECT_THAT(trials, Contains(Field(&ModelTrial::model, ::testing::Ne("brown_conrady")))) << found.words;
  EXPECT_THAT(trials, Each(Field(&ModelTrial::rms_px, ::testing::Gt(0.0))));
}

TEST(CrossValidation, ALensThatTheModelDoesNotFitIsAModelErrorThatAnotherModelMends) {
  testing::SyntheticWorld world = synthetic_world(narrow("brown_conrady", {-0.25, 0.1, 0.0, 0.0, 0.0}));
  world.problem.cameras[0].model = *model_named("pinhole");
  const CrossValidation found = validated(world.problem);
  EXPECT_EQ(found.verdict, Verdict::kModelError) << found.words;
  EXPECT_THAT(found.trials, Contains(Field(&ModelTrial::agrees, true)));
  EXPECT_THAT(found.words, HasSubstr("mends camera camera0"));
}

// The right camera exposes a little later, and the board has moved by up to three sigmas of a corner: each camera alone
// takes that for another place of the board. Frames that are told to tie the cameras all the same bend the lenses; eight
// of a half are too few for sigmas by frames, which would explain it, too.
TEST(CrossValidation, LensesThatOnlyTheTiesBendAreToldByTheCamerasAlone) {
  SyntheticOptions options = stereo(3);
  options.frames = 16;
  options.noise_px = 0.3;
  CalibrationProblem problem = synthetic_world(options).problem;
  for (TargetView& view : problem.views) {
    if (view.camera == 0) continue;
    const Eigen::Vector2d moved_px(std::sin(2.1 * view.frame), std::cos(3.3 * view.frame));
    for (Observation& seen : view.observations) seen.pixel += moved_px;
  }
  const CrossValidation found = validated(problem, {.tie_sigma = 1000.0});
  EXPECT_EQ(found.verdict, Verdict::kTiesDisagree) << found.words;
  EXPECT_THAT(found.words, HasSubstr("when it is calibrated alone"));
}

// Corners of a view that err together, by more than their noise, as no lens would have them.
TEST(CrossValidation, CornersOfAFrameThatErrTogetherAreExplainedByTheFrames) {
  SyntheticOptions options = narrow("rational", {});
  options.frames = 30;
  options.noise_px = 0.2;
  CalibrationProblem problem = synthetic_world(options).problem;
  testing::Draw draw(1);
  for (TargetView& view : problem.views) {
    const double slope[] = {draw.normal(0.06), draw.normal(0.06)};
    for (Observation& seen : view.observations) {
      const Eigen::Vector2d r = (seen.pixel - Eigen::Vector2d(640, 480)) / 100.0;
      seen.pixel += Eigen::Vector2d(slope[0] * r.x() * std::abs(r.x()), slope[1] * r.y() * std::abs(r.y()));
    }
  }
  const CrossValidation found = validated(problem);
  EXPECT_EQ(found.verdict, Verdict::kAgreeByFrames) << found.words;
  ASSERT_TRUE(found.by_corners && found.by_frames);
  EXPECT_FALSE(found.by_corners->agrees());
  EXPECT_TRUE(found.by_frames->agrees());
}

}  // namespace
}  // namespace raybundle
