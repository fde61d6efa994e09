// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "laser_worlds.hpp"

namespace raybundle::testing {
namespace {

const LaserOptions kFewBeams{.grid = {.rows = 5, .columns = 5}, .noise_px = 0.0};

int beams_of(const BundleState& state) {
  return static_cast<int>(std::ranges::count_if(state.beams, [](const auto& beam) { return beam.has_value(); }));
}

// Exact corners and dots: the truth comes back from a disturbed start.
void expect_truth(const SyntheticOptions& options, const BundleOptions& bundle = {}) {
  const LaserWorld made = laser_world(options, kFewBeams);
  ASSERT_GE(beams_of(made.truth), 10);
  BundleState state = disturbed_beams(made.truth);
  mark_projectable(made.world.problem, state);
  mark_dots(made.world.problem, state);
  const BundleSummary summary = solve_bundle(made.world.problem, state, bundle);
  EXPECT_EQ(summary.termination, Termination::kConverged) << summary.message;
  EXPECT_LE(largest_difference(state, made.truth), 1e-8) << summary.message;
  EXPECT_LE(largest_beam_difference(state, made.truth), 1e-8) << summary.message;
  EXPECT_GT(summary.initial_cost, 1.0);
  EXPECT_LT(summary.final_cost, 1e-12);
  EXPECT_LT(summary.iterations, 20);
}

TEST(RecoverBeams, OneCamera) { expect_truth(small_laser_rig(1, 30)); }
TEST(RecoverBeams, Stereo) { expect_truth(small_laser_rig(2, 20)); }
TEST(RecoverBeams, FewPoses) { expect_truth(small_laser_rig(2, 8)); }

TEST(RecoverBeams, BentBoard) {
  SyntheticOptions options = small_laser_rig(2, 20);
  options.shape = {0.004, -0.003, 0.002};
  expect_truth(options, {.estimate_shape = true});
}

TEST(RecoverBeams, WithRobustLoss) { expect_truth(small_laser_rig(1, 20), {.robust_scale_sigma = 5.0}); }

}  // namespace
}  // namespace raybundle::testing
