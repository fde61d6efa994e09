// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../calib_core/calibrate/src/mirrored_boards.hpp"

#include <gtest/gtest.h>

#include "draw.hpp"
#include "true_state.hpp"

namespace raybundle {
namespace {

using testing::SyntheticOptions;
using testing::SyntheticWorld;

// Boards of some 27 px, which look nearly the same from their mirrored pose: it moves corners by tenths of a pixel.
SyntheticOptions far_boards() {
  SyntheticOptions options;
  options.frames = 12;
  options.min_distance_m = 4.0;
  options.max_distance_m = 5.0;
  options.max_off_axis_rad = 0.5;
  return options;
}

// Every other corner of the boards is known better.
void add_noise(double of_even_px, double of_odd_px, CalibrationProblem& problem) {
  testing::Draw draw(5);
  for (TargetView& view : problem.views) {
    for (Observation& seen : view.observations) {
      seen.sigma_px = seen.point_id % 2 == 0 ? of_even_px : of_odd_px;
      for (double& coordinate : seen.pixel) coordinate += draw.normal(seen.sigma_px);
    }
  }
}

double cost_of(const CalibrationProblem& problem, BundleState state) {
  return solve_bundle(problem, state, {.max_iterations = 0}).final_cost;
}

void turn(const CalibrationProblem& problem, BundleState& state) {
  turn_mirrored_boards(state, find_mirrored_boards(problem, state, 1));
}

// By the pixels alone, nearly all of whose squares are those of the worse corners, any pose fits better that takes up a
// part of their noise.
TEST(MirroredBoards, TurnNotWhereTheBetterCornersSpeakAgainstIt) {
  SyntheticWorld world = testing::synthetic_world(far_boards());
  add_noise(0.05, 2.0, world.problem);
  const BundleState truth = testing::true_state(world);
  BundleState state = truth;
  turn(world.problem, state);
  EXPECT_LE(cost_of(world.problem, state), cost_of(world.problem, truth));
}

// Two centimetres of 32: were it taken for flat, any pose would fit better that takes up a part of the bend.
TEST(MirroredBoards, TurnNotWhereABendThatIsHeldSpeaksAgainstIt) {
  SyntheticOptions options = far_boards();
  options.shape.bend_x_m = 0.02;
  options.noise_px = 0.1;
  SyntheticWorld world = testing::synthetic_world(options);
  world.problem.rules = {{"board0.bend_x", ParameterRule::Kind::kFixed, options.shape.bend_x_m, 0.0}};
  const BundleState truth = testing::true_state(world);
  BundleState state = truth;
  turn(world.problem, state);
  EXPECT_LE(cost_of(world.problem, state), cost_of(world.problem, truth));
}

TEST(MirroredBoards, TurnBackWhereAllCornersSpeakForIt) {
  SyntheticWorld world = testing::synthetic_world(far_boards());
  add_noise(0.05, 0.2, world.problem);
  const BundleState truth = testing::true_state(world);
  BundleState state = truth;
  int mirrored = 0;
  for (const MirroredBoard& board : find_mirrored_boards(world.problem, truth, 1)) {
    if (board.growth < 0.1) continue;  // six squared sigmas of a board: it is hardly tilted, or the noise is against it
    state.poses[state.pose_of_view[board.view]].rig_from_target = board.camera_from_target;
    ++mirrored;
  }
  ASSERT_GT(mirrored, 0);
  EXPECT_GT(cost_of(world.problem, state), cost_of(world.problem, truth));
  turn(world.problem, state);
  EXPECT_LE(cost_of(world.problem, state), cost_of(world.problem, truth));
}

}  // namespace
}  // namespace raybundle
