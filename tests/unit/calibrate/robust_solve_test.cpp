// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../calib_core/calibrate/src/robust_solve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "raybundle/calibrate/lens_prior.hpp"
#include "rig_worlds.hpp"
#include "true_state.hpp"

namespace raybundle {
namespace {

using ::testing::HasSubstr;
using testing::SyntheticOptions;
using testing::SyntheticWorld;
using testing::true_state;

// A rational lens with 70 degrees across, before some boards.
SyntheticOptions rational_options(double noise_px) {
  SyntheticOptions options;
  options.columns = 14;
  options.rows = 10;
  options.square_m = 0.025;
  options.frames = 8;
  options.noise_px = noise_px;
  options.max_off_axis_rad = 0.35;
  options.min_distance_m = 0.4;
  options.cameras[0].model = "rational";
  options.cameras[0].focal_px = 910.0;
  return options;
}

SolvedState solved(BundleState state, Termination termination = Termination::kConverged) {
  SolvedState result{std::move(state), {}, {}};
  result.summary.termination = termination;
  return result;
}

// Corners tell what there is to tell, also exact ones, which leave nothing but rounding: a prior that says less than a
// millionth of it decides nothing.
TEST(IsBetter, ALensThatFitsIsBetterThanOneThatThePriorsLike) {
  const SyntheticWorld world = testing::synthetic_world(rational_options(0.0));
  CalibrationProblem problem = world.problem;
  const BundleState truth = true_state(world);
  ASSERT_TRUE(weigh_lens_priors(problem, truth));
  BundleState poor = truth;
  for (const int k : {4, 5, 8, 9, 10, 11}) poor.cameras[0].parameters[k] = 0.0;  // k1 to k6, where the priors are
  CalibrationProblem held = problem;
  held.rules = {{"camera0.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0}};
  ASSERT_NE(solve_bundle(held, poor).termination, Termination::kFailed);
  EXPECT_TRUE(is_better(problem, solved(truth), solved(poor), {}));
  EXPECT_FALSE(is_better(problem, solved(poor), solved(truth), {}));
  EXPECT_FALSE(is_better(problem, solved(truth), solved(truth), {}));
  EXPECT_FALSE(is_better(problem, solved(truth, Termination::kFailed), solved(poor), {}));
  EXPECT_TRUE(is_better(problem, solved(poor), solved(truth, Termination::kFailed), {}));
}

TEST(PriorSquares, AreThoseOfTheSigmasFromTheMean) {
  SyntheticWorld world = testing::synthetic_world(testing::stereo(3));
  BundleState state = true_state(world);
  world.problem.cameras[1].camera_from_rig = world.camera_from_rig[1];
  world.problem.rules = {{"camera0.fx", ParameterRule::Kind::kPrior, state.cameras[0].fx(), 2.0},
                         {"camera1.camera_from_rig.rotation_y", ParameterRule::Kind::kPrior, {}, 0.01}};
  EXPECT_LT(prior_squares(world.problem, state), 1e-20);  // rounding of a rotation over its sigma, squared
  state.cameras[0].parameters[0] += 3.0 * 2.0;
  EXPECT_NEAR(prior_squares(world.problem, state), 9.0, 1e-12);
  Eigen::Matrix<double, 6, 1> turn = Eigen::Matrix<double, 6, 1>::Zero();
  turn[1] = 4.0 * 0.01;
  state.camera_from_rig[1] = perturbed(state.camera_from_rig[1], turn);
  EXPECT_NEAR(prior_squares(world.problem, state), 9.0 + 16.0, 1e-9);
}

// What a solve makes small, with priors of the lens, by a rule, and of a rotation.
TEST(AllSquares, AreTwiceTheCostOfTheBundleWhereNoCornerIsCutOff) {
  SyntheticOptions options = rational_options(0.2);
  options.cameras.push_back(options.cameras[0]);
  options.cameras[1].camera_from_rig = testing::beside(0.12, 0.1);
  SyntheticWorld world = testing::synthetic_world(options);
  CalibrationProblem& problem = world.problem;
  BundleState state = true_state(world);
  ASSERT_TRUE(weigh_lens_priors(problem, state));
  problem.rules = {{"camera0.fx", ParameterRule::Kind::kPrior, state.cameras[0].fx() + 3.0, 1.5},
                   {"camera1.camera_from_rig.rotation_y", ParameterRule::Kind::kPrior, 0.12, 0.01}};
  const double squares = all_squares(problem, state, std::numeric_limits<double>::infinity());
  EXPECT_GT(prior_squares(problem, state), 4.0);  // two sigmas of the focal length alone
  const double cost = solve_bundle(problem, state, {.max_iterations = 0}).final_cost;
  EXPECT_NEAR(2.0 * cost, squares, 1e-12 * squares);  // rounding of some thousand summands
  EXPECT_LT(all_squares(problem, state, 1.0), squares);
}

/// A world with noise, its true state, and views with reasons.
struct NoisyWorld {
  SyntheticWorld world;
  BundleState truth;
  std::vector<std::string> reasons;

  explicit NoisyWorld(SyntheticOptions options) {
    options.noise_px = 0.2;
    world = testing::synthetic_world(options);
    truth = true_state(world);
    reasons.resize(world.problem.views.size());
  }

  // A view of the first camera that shows the whole board.
  int whole_view() const {
    for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
      const TargetView& view = world.problem.views[v];
      if (view.camera == 0 && view.observations.size() == world.problem.targets[0].points.size())
        return static_cast<int>(v);
    }
    throw std::logic_error("no view shows the whole board");
  }
};

// Puts a corner so many sigmas beside where the state projects it.
void displace(const BundleState& state, int view, std::size_t corner, double sigmas, CalibrationProblem& problem) {
  Observation& seen = problem.views[view].observations[corner];
  seen.pixel -= view_residuals(problem, state, view)[corner];
  seen.pixel.x() += sigmas * seen.sigma_px;
}

// The limit is 5 sigmas of the noise as the corners tell it, within a few percent.
TEST(MarkOutliers, LeavesOutACornerBeyondTheLimitUntilItFitsAgain) {
  NoisyWorld noisy{SyntheticOptions{}};
  const CalibrationProblem& right = noisy.world.problem;
  BundleState state = noisy.truth;
  EXPECT_FALSE(mark_outliers(right, state, {}, noisy.reasons));
  CalibrationProblem moved = right;
  displace(state, 3, 7, 4.0, moved);
  EXPECT_FALSE(mark_outliers(moved, state, {}, noisy.reasons));
  displace(state, 3, 7, 6.0, moved);
  EXPECT_TRUE(mark_outliers(moved, state, {}, noisy.reasons));
  BundleState without = noisy.truth;
  without.fates[3][7] = ObservationFate::kOutlier;
  EXPECT_EQ(state.fates, without.fates);
  EXPECT_TRUE(mark_outliers(right, state, {}, noisy.reasons));
  EXPECT_EQ(state.fates, noisy.truth.fates);
}

TEST(MarkOutliers, SetsAsideAViewOfWhichMostCornersAreWrongUntilTheyFitAgain) {
  NoisyWorld noisy{SyntheticOptions{}};
  const int view = noisy.whole_view();
  const CalibrationProblem& right = noisy.world.problem;
  const std::size_t half = right.views[view].observations.size() / 2;  // of 63 corners: 31
  BundleState state = noisy.truth;
  CalibrationProblem wrong = right;
  for (std::size_t i = 0; i < half; ++i) displace(state, view, i, 20.0, wrong);
  mark_outliers(wrong, state, {}, noisy.reasons);
  EXPECT_EQ(state.pose_of_view, noisy.truth.pose_of_view);
  displace(state, view, half, 20.0, wrong);
  EXPECT_TRUE(mark_outliers(wrong, state, {}, noisy.reasons));
  EXPECT_EQ(state.pose_of_view[view], -1);
  EXPECT_THAT(state.fates[view], ::testing::Each(ObservationFate::kViewSetAside));
  EXPECT_THAT(noisy.reasons[view], HasSubstr("only 31 of 63 corners fit the camera"));

  EXPECT_TRUE(give_second_chance(right, state, {}, noisy.reasons));
  ASSERT_GE(state.pose_of_view[view], 0);
  solve_without_outliers(right, state, {}, false, noisy.reasons);
  EXPECT_EQ(state.fates, noisy.truth.fates);
  const Rigid3& truth = noisy.truth.poses[noisy.truth.pose_of_view[view]].rig_from_target;
  EXPECT_LT(angle_between(state.poses[state.pose_of_view[view]].rig_from_target, truth), 0.01);  // 0.2 px of some 200
}

// Five right corners of one row, and four wrong ones of the next: about that row the board may turn freely, unless
// another camera sees it.
TEST(MarkOutliers, SetsAsideAViewWhoseRightCornersLieOnOneLineUnlessItsPoseIsShared) {
  for (const bool shared : {false, true}) {
    NoisyWorld noisy{shared ? testing::stereo(3) : SyntheticOptions{}};
    const int view = noisy.whole_view();
    CalibrationProblem& problem = noisy.world.problem;
    const bool another = std::ranges::count(noisy.truth.pose_of_view, noisy.truth.pose_of_view[view]) > 1;
    ASSERT_EQ(another, shared);
    std::erase_if(problem.views[view].observations,
                  [](const Observation& seen) { return seen.point_id % 9 > 4 || seen.point_id > 12; });
    ASSERT_EQ(problem.views[view].observations.size(), 9U);
    BundleState state = true_state(noisy.world);
    for (std::size_t i = 5; i < 9; ++i) displace(state, view, i, 20.0, problem);
    EXPECT_TRUE(mark_outliers(problem, state, {}, noisy.reasons));
    EXPECT_EQ(state.pose_of_view[view] >= 0, shared);
    EXPECT_EQ(std::ranges::count(state.fates[view], ObservationFate::kUsed), shared ? 5 : 0);
    EXPECT_THAT(noisy.reasons[view], HasSubstr(shared ? "" : "the 5 of 9 corners that fit the camera lie on one line"));
  }
}

// A board that other cameras saw in the frame stays one board.
TEST(GiveSecondChance, TakesThePoseThatOtherCamerasSaw) {
  NoisyWorld noisy{testing::stereo(3)};
  const int view = noisy.whole_view();
  BundleState state = noisy.truth;
  ASSERT_GT(std::ranges::count(state.pose_of_view, state.pose_of_view[view]), 1);
  state.pose_of_view[view] = -1;
  std::ranges::fill(state.fates[view], ObservationFate::kViewSetAside);
  EXPECT_TRUE(give_second_chance(noisy.world.problem, state, {}, noisy.reasons));
  EXPECT_EQ(state.pose_of_view, noisy.truth.pose_of_view);
  EXPECT_EQ(state.fates, noisy.truth.fates);
}

}  // namespace
}  // namespace raybundle
