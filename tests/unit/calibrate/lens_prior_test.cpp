// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// What is known of rational lenses beforehand.
#include "raybundle/calibrate/lens_prior.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "random_rig.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "synthetic_world.hpp"
#include "true_state.hpp"

namespace raybundle {
namespace {

using testing::true_state;

// A rational lens with 70 degrees across, before 20 boards.
testing::SyntheticWorld world_of(double noise_px) {
  testing::SyntheticOptions options;
  options.columns = 14;
  options.rows = 10;
  options.square_m = 0.025;
  options.frames = 20;
  options.noise_px = noise_px;
  options.max_tilt_rad = 0.7;
  options.max_off_axis_rad = 0.35;
  options.min_distance_m = 0.4;
  options.cameras[0].model = "rational";
  options.cameras[0].focal_px = 910.0;
  return testing::synthetic_world(options);
}

Parameter parameter_named(const CalibrationProblem& problem, const std::string& name) {
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    for (const Parameter& parameter : block.parameters) {
      if (parameter.name == name) return parameter;
    }
  }
  ADD_FAILURE() << name;
  return {};
}

TEST(LensPrior, IsWeighedByNoiseAndField) {
  const testing::SyntheticWorld world = world_of(0.3);
  CalibrationProblem problem = world.problem;
  const std::string camera = problem.cameras[0].name + ".";
  ASSERT_TRUE(weigh_lens_priors(problem, true_state(world)));
  EXPECT_FALSE(weigh_lens_priors(problem, true_state(world))) << "the same again";
  const Parameter k1 = parameter_named(problem, camera + "k1"), k6 = parameter_named(problem, camera + "k6");
  EXPECT_EQ(k1.kind, ParameterRule::Kind::kPrior);
  // Noise and field are each rounded by a fourth of an octave at most; the field is the tangent of 35 to 50 degrees.
  const double noise = 0.3 / problem.views[0].observations[0].sigma_px, octaves = std::exp2(0.5);
  EXPECT_GT(k1.sigma, 1.0 / noise / octaves);
  EXPECT_LT(k1.sigma, 2.0 / noise * octaves);
  EXPECT_GT(k6.sigma, k1.sigma);
  EXPECT_EQ(parameter_named(problem, camera + "p1").kind, ParameterRule::Kind::kFree);
}

// Nearly the same double sphere lies on both sides of xi = 0, where the model folds: corners alone choose by noise, and
// sigmas do not tell of the other side.
TEST(LensPrior, KeepsADoubleSphereOnItsSide) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    testing::SyntheticOptions options;
    options.frames = 20;
    options.noise_px = 0.1;
    options.max_off_axis_rad = 0.7;
    options.seed = seed;
    options.cameras[0].model = "double_sphere";
    options.cameras[0].focal_px = 300.0;
    options.cameras[0].shape = {-0.1, 0.55};
    const CalibrationResult result = calibrate(testing::synthetic_world(options).problem);
    const RigCamera& camera = result.calibration.cameras[0];
    EXPECT_NEAR(camera.camera.parameters[4], -0.1, 4.0 * result.calibration.covariance.sigma(camera.name + ".xi"))
        << "seed " << seed;
  }
}

TEST(LensPrior, NeedsViews) {
  const testing::SyntheticWorld world = world_of(0.3);
  CalibrationProblem problem = world.problem;
  BundleState state = true_state(world);
  ASSERT_TRUE(weigh_lens_priors(problem, state));
  std::ranges::fill(state.pose_of_view, -1);
  EXPECT_TRUE(weigh_lens_priors(problem, state));
  EXPECT_TRUE(problem.lens_priors.empty()) << "of no noise and no field";
}

TEST(LensPrior, GivesWayToAnyRule) {
  const testing::SyntheticWorld world = world_of(0.3);
  CalibrationProblem problem = world.problem;
  const std::string camera = problem.cameras[0].name + ".";
  problem.rules = {{camera + "k6", ParameterRule::Kind::kFixed, 0.0, 0.0},
                   {camera + "k2", ParameterRule::Kind::kFree, {}, 0.0}};
  ASSERT_TRUE(weigh_lens_priors(problem, true_state(world)));
  EXPECT_EQ(parameter_named(problem, camera + "k6").kind, ParameterRule::Kind::kFixed);
  EXPECT_EQ(parameter_named(problem, camera + "k2").kind, ParameterRule::Kind::kFree);
  EXPECT_EQ(parameter_named(problem, camera + "k1").kind, ParameterRule::Kind::kPrior);
}

TEST(LensPrior, IsToldWhereItIsInForce) {
  testing::SyntheticWorld world = world_of(0.3);
  const std::string camera = world.problem.cameras[0].name + ".";
  world.problem.rules = {{camera + "k6", ParameterRule::Kind::kFixed, 0.0, 0.0},
                         {camera + "k5", ParameterRule::Kind::kFixed, 0.0, 0.0},
                         {camera + "k3", ParameterRule::Kind::kFree, {}, 0.0},
                         {camera + "k1", ParameterRule::Kind::kPrior, world.cameras[0].parameters[4], 0.1}};
  std::vector<std::string> told;
  for (const ParameterRule& prior : calibrate(world.problem).lens_priors) told.push_back(prior.pattern);
  EXPECT_THAT(told, ::testing::UnorderedElementsAre(camera + "k2", camera + "k4"));
}

TEST(LensPrior, KeepsAUnifiedLensFromRunningAway) {
  const testing::RandomRig rig = testing::random_rig(*model_named("unified"), 14054);  // without it: xi = 430
  const CalibrationResult result = calibrate(rig.problem);
  std::vector<std::string> told;
  for (const ParameterRule& prior : result.lens_priors) told.push_back(prior.pattern);
  EXPECT_THAT(told, ::testing::ElementsAre(rig.problem.cameras[0].name + ".xi"));
  EXPECT_LT(std::abs(result.calibration.cameras[0].camera.parameters[4] - 1.0), 3.0);  // three sigmas of the prior
  EXPECT_EQ(result.termination, Termination::kConverged);
}

TEST(LensPrior, KeepsBetaWhereAnExtendedUnifiedLensIsNearlyRectilinear) {
  const testing::RandomRig rig = testing::random_rig(*model_named("extended_unified"), 20564);  // without it: 731
  const CalibrationResult result = calibrate(rig.problem);
  EXPECT_LT(std::abs(result.calibration.cameras[0].camera.parameters[5] - 1.0), 3.0);  // three sigmas of the prior
}

TEST(LensPrior, OtherModelsHaveNone) {
  for (const std::string_view model : {"pinhole", "brown_conrady", "kannala_brandt", "field_of_view"}) {
    testing::RandomRig rig = testing::random_rig(*model_named(model), 1);
    EXPECT_FALSE(weigh_lens_priors(rig.problem, rig.truth)) << model;
    EXPECT_TRUE(rig.problem.lens_priors.empty()) << model;
  }
}

// Without the prior these 2800 noisy corners are fitted best with a pole just beyond the outermost of them.
TEST(LensPrior, KeepsPolesAwayFromTheCorners) {
  const testing::SyntheticWorld world = world_of(0.3);
  const BundleState truth = true_state(world);
  CalibrationProblem problem = world.problem;
  BundleState without = truth;
  solve_bundle(problem, without);
  weigh_lens_priors(problem, truth);
  BundleState with = truth;
  solve_bundle(problem, with);
  constexpr double kDegree = M_PI / 180.0;  // boards reach 40 to 50 degrees off the axis
  EXPECT_LT(max_angle_rad(without.cameras[0]), 60 * kDegree);
  EXPECT_GT(max_angle_rad(with.cameras[0]), 60 * kDegree);
}

// Exact corners tell all there is to tell: the prior weighs as nothing against them.
TEST(LensPrior, LeavesExactCornersAlone) {
  const testing::SyntheticWorld world = world_of(0.0);
  const CalibrationResult result = calibrate(world.problem);
  EXPECT_LT(result.rms_px, 1e-8);
  ASSERT_FALSE(result.lens_priors.empty());
}

}  // namespace
}  // namespace raybundle
