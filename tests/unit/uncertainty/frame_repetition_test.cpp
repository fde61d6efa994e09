// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/frame_repetition.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/uncertainty/frame_covariance.hpp"
#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

// Each pose seen so many times, with errors of which a share is the same each time.
SyntheticWorld repeated_world(unsigned seed, int poses, int times, double share) {
  SyntheticOptions options = fisheye_options(seed);
  options.noise_px = 0.0;
  options.frames = poses;
  const SyntheticWorld once = synthetic_world(options);
  SyntheticWorld world = once;
  world.problem.views.clear();
  world.problem.frames.clear();
  world.poses.clear();
  world.pose_of_view.clear();
  std::mt19937 random(seed);
  const double sigma_px = 0.2;
  std::normal_distribution<double> normal_of_all, normal_own;  // of unit scatter: a share may be nothing
  const double of_all_px = sigma_px * std::sqrt(share), own_px = sigma_px * std::sqrt(1.0 - share);
  for (std::size_t v = 0; v < once.problem.views.size(); ++v) {
    TargetView common = once.problem.views[v];
    for (Observation& o : common.observations) {
      o.pixel += of_all_px * Eigen::Vector2d(normal_of_all(random), normal_of_all(random));
      o.sigma_px = sigma_px;
    }
    for (int k = 0; k < times; ++k) {
      TargetView view = common;
      view.frame = static_cast<int>(world.problem.frames.size());
      for (Observation& o : view.observations) {
        o.pixel += own_px * Eigen::Vector2d(normal_own(random), normal_own(random));
      }
      world.problem.frames.push_back(std::to_string(view.frame));
      world.problem.views.push_back(view);
      world.poses.push_back(once.poses[once.pose_of_view[v]]);
      world.poses.back().frame = view.frame;
      world.pose_of_view.push_back(static_cast<int>(world.poses.size()) - 1);
    }
  }
  return world;
}

FrameRepetition repetition_of(const SyntheticWorld& world) {
  return frame_repetition(world.problem, calibrate(world.problem));
}

TEST(FrameRepetition, CountsFramesByWhatTheyTell) {
  const FrameRepetition found = repetition_of(repeated_world(1, 12, 4, 0.8));
  EXPECT_EQ(found.frames, 48);
  EXPECT_GE(found.pairs, 12 * 6);
  EXPECT_NEAR(found.correlation, 0.8, 0.1);                                  // the fit takes some of what is shared
  EXPECT_NEAR(found.worth, 48 / (1.0 + 3.0 * found.correlation), 0.1 * 14);  // chance brings other poses near
}

TEST(FrameRepetition, IsNothingForIndependentErrors) {
  EXPECT_EQ(repetition_of(repeated_world(2, 12, 4, 0.0)).correlation, 0.0);
  EXPECT_EQ(repetition_of(synthetic_world(fisheye_options(2))).correlation, 0.0);
}

// Over many samples of the noise the focal length scatters as the covariance by frames says, but by more than the plain
// one: half of sqrt(1 + 3 · 0.8) at most. 60 samples tell a standard deviation to 9 %.
TEST(FrameRepetition, MakesTheCovarianceByFramesCoverTheScatter) {
  constexpr int kSamples = 60;
  double squares = 0.0, plain = 0.0, by_frame = 0.0;
  for (unsigned seed = 1; seed <= kSamples; ++seed) {
    const SyntheticWorld world = repeated_world(seed, 12, 4, 0.8);
    BundleState state = true_state(world);
    solve_bundle(world.problem, state);
    const ReducedInformation all = reduced_information(world.problem, state);
    const auto repeated = repeated_errors(world.problem, state, all.names);
    ASSERT_TRUE(repeated);
    const Covariance known = covariance(all).covariance;
    const auto frames = covariance_by_frame(all, information_by_frame(world.problem, state), repeated);
    ASSERT_TRUE(frames);
    // Each sample has a world of its own: errors are counted in units of their sigmas.
    const double error = state.cameras[0].fx() - world.cameras[0].fx(), unit = known.sigma("camera0.fx");
    squares += error * error / (unit * unit);
    plain += 1.0;
    by_frame += std::pow(frames->sigma("camera0.fx") / unit, 2);
  }
  const double scatter = std::sqrt(squares / kSamples);
  EXPECT_GT(scatter / std::sqrt(plain / kSamples), 1.4);
  EXPECT_NEAR(std::sqrt(by_frame / kSamples) / scatter, 1.0, 0.25);
}

}  // namespace
}  // namespace raybundle::testing
