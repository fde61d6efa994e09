// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Lenses that end among their corners: a pole of the profile that fits between two corners.
#include "raybundle/calibrate/lens_domain.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "synthetic_world.hpp"
#include "true_state.hpp"

namespace raybundle {
namespace {

using testing::true_state;

constexpr double kAbove = 0.3, kBelow = 0.5;  // the lens is (1 + 0.3 r²) / (1 + 0.5 r²)

// A rational lens of which only k1 and k4 are not zero, seen without noise up to 50 degrees.
testing::SyntheticWorld simple_world() {
  testing::SyntheticOptions options;
  options.seed = 5;
  options.max_off_axis_rad = 0.6;
  testing::SyntheticCamera camera;
  camera.model = "rational";
  camera.size = {1280, 1100};
  camera.focal_px = 600;
  camera.shape = {kAbove, 0, 0, 0, 0, kBelow, 0, 0};
  options.cameras = {camera};
  return synthetic_world(options);
}

// The same lens with the factor (1 - r² / v)² above and below: a double pole at r² = v, and no other difference.
Camera with_pole(Camera camera, double v) {
  camera.parameters[4] = kAbove - 2 / v;
  camera.parameters[5] = 1 / (v * v) - 2 * kAbove / v;
  camera.parameters[8] = kAbove / (v * v);
  camera.parameters[9] = kBelow - 2 / v;
  camera.parameters[10] = 1 / (v * v) - 2 * kBelow / v;
  camera.parameters[11] = kBelow / (v * v);
  return camera;
}

BundleSummary solve(const CalibrationProblem& problem, BundleState& state) { return solve_bundle(problem, state); }

TEST(LensDomain, APoleBetweenTwoCornersEndsTheLensThere) {
  const testing::SyntheticWorld world = simple_world();
  BundleState state = true_state(world);
  EXPECT_FALSE(ends_among_corners(world.problem, state, 0));
  const BundleState before = state;
  state.cameras[0] = with_pole(state.cameras[0], 0.25);
  mark_projectable(world.problem, state);
  EXPECT_EQ(state.fates, before.fates);  // every corner projects, and where it did
  EXPECT_TRUE(ends_among_corners(world.problem, state, 0));
  EXPECT_TRUE(spoils_lens(world.problem, before, state));
  EXPECT_FALSE(spoils_lens(world.problem, state, state));
}

TEST(LensDomain, ALensWithAPoleIsReplacedByOneThatFitsAsWell) {
  const testing::SyntheticWorld world = simple_world();
  for (const double v : {0.1, 0.25, 0.6}) {
    CalibrationProblem problem = world.problem;
    BundleState state = true_state(world);
    state.cameras[0] = with_pole(state.cameras[0], v);
    mark_projectable(problem, state);
    BundleSummary summary;
    ASSERT_TRUE(give_up_coefficients(problem, state, 0, summary, solve)) << v;
    EXPECT_FALSE(ends_among_corners(problem, state, 0)) << v;
    EXPECT_LT(summary.final_cost, 1e-9) << v;  // half the sum of squares [px²] of some thousand exact corners
    EXPECT_THAT(state.fates, ::testing::Each(::testing::Each(ObservationFate::kUsed)));
  }
}

TEST(LensDomain, CoefficientsWithAPriorByARuleAreNotGivenUp) {
  const testing::SyntheticWorld world = simple_world();
  CalibrationProblem problem = world.problem;
  BundleState state = true_state(world);
  state.cameras[0] = with_pole(state.cameras[0], 0.25);
  problem.rules = {{"*.k?", ParameterRule::Kind::kPrior, 0.0, 1e3}};
  BundleSummary summary;
  EXPECT_FALSE(give_up_coefficients(problem, state, 0, summary, solve));
  problem.rules.clear();
  weigh_lens_priors(problem, state);
  EXPECT_TRUE(give_up_coefficients(problem, state, 0, summary, solve));
}

TEST(LensDomain, CoefficientsThatAreFixedAreNotTouched) {
  const testing::SyntheticWorld world = simple_world();
  CalibrationProblem problem = world.problem;
  BundleState state = true_state(world);
  state.cameras[0] = with_pole(state.cameras[0], 0.25);
  problem.cameras[0].parameters = state.cameras[0].parameters;
  problem.rules = {{"*.k?", ParameterRule::Kind::kFixed, {}, 0.0}};
  BundleSummary summary;
  EXPECT_FALSE(give_up_coefficients(problem, state, 0, summary, solve));
  EXPECT_EQ(state.cameras[0].parameters, *problem.cameras[0].parameters);
}

// The start's denominator ends at 30 degrees, and corners beyond do not project: they cannot pull the lens back.
TEST(LensDomain, AStartThatEndsAmongTheCornersLosesNone) {
  testing::SyntheticWorld world = simple_world();
  Eigen::VectorXd start = world.cameras[0].parameters;
  start[9] = -3.0;
  world.problem.cameras[0].parameters = start;
  const CalibrationResult result = calibrate(world.problem);
  for (const ViewResult& view : result.views) {
    EXPECT_THAT(view.fates, ::testing::Each(ObservationFate::kUsed));
  }
  EXPECT_LT(result.rms_px, 1e-6);
}

// A small board and few frames, in which it moved between the exposures: ties that would bend both lenses.
testing::SyntheticWorld moving_world(unsigned seed) {
  testing::SyntheticOptions options;
  options.seed = seed;
  options.columns = 5;
  options.rows = 3;
  options.square_m = 0.05;
  options.frames = 5 + static_cast<int>(seed) % 4;
  options.noise_px = 0.3;
  options.max_off_axis_rad = 0.4;
  options.min_points = 6;
  testing::SyntheticCamera camera;
  camera.model = "rational";
  camera.size = {1280, 720};
  camera.focal_px = 700;
  options.cameras = {camera, camera};
  options.cameras[1].camera_from_rig.translation = {-0.1, 0, 0};
  testing::SyntheticWorld world = synthetic_world(options);
  for (TargetView& view : world.problem.views) {
    if (view.camera == 0) continue;
    const Eigen::Vector2d moved_px(6 * std::sin(2.1 * view.frame), 6 * std::cos(3.3 * view.frame));
    for (Observation& observation : view.observations) observation.pixel += moved_px;
  }
  return world;
}

TEST(LensDomain, TiesEndNoLensAmongItsCorners) {
  for (const unsigned seed : {1u, 7u, 30u}) {
    const testing::SyntheticWorld world = moving_world(seed);
    const CalibrationResult result = calibrate(world.problem, {.threads = 1});
    BundleState state{
        .cameras = {}, .camera_from_rig = {}, .poses = result.poses, .shapes = {}, .pose_of_view = {}, .fates = {}};
    for (const RigCamera& camera : result.calibration.cameras) {
      state.cameras.push_back(camera.camera);
      state.camera_from_rig.push_back(camera.camera_from_rig);
    }
    for (const ViewResult& view : result.views) {
      state.pose_of_view.push_back(view.pose);
      state.fates.push_back(view.fates);
    }
    ASSERT_EQ(state.cameras.size(), 2u) << seed;
    for (int c = 0; c < 2; ++c) EXPECT_FALSE(ends_among_corners(world.problem, state, c)) << seed << ", camera " << c;
  }
}

}  // namespace
}  // namespace raybundle
