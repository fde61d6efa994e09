// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/beam_start.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laser_world.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

using testing::add_laser;
using testing::laser_rig_options;
using testing::LaserOptions;
using testing::LaserTruth;
using testing::SyntheticWorld;

// Cameras and boards as they are; the start of a calibration knows them nearly as well.
LaserScene true_scene(const SyntheticWorld& world) {
  LaserScene scene{world.problem, world.cameras, world.camera_from_rig, {}, world.shapes};
  for (int pose : world.pose_of_view) scene.rig_from_target.push_back(world.poses[pose].rig_from_target);
  return scene;
}

struct Score {
  int right = 0;
  int wrong = 0;    // a beam's dot, taken for another beam's
  int chance = 0;   // no beam's dot, but it lies where one was to be expected
  int missing = 0;  // a beam's dot without a label
};

Score score(const BeamStart& start, const LaserTruth& truth) {
  Score score;
  for (std::size_t v = 0; v < truth.beam_of_dot.size(); ++v) {
    for (std::size_t d = 0; d < truth.beam_of_dot[v].size(); ++d) {
      const int is = start.beam_of_dot[v][d];
      const int should_be = truth.beam_of_dot[v][d];
      if (is == kUnlabelled) {
        score.missing += should_be != kUnlabelled;
      } else if (should_be == kUnlabelled) {
        ++score.chance;
      } else {
        ++(is == should_be ? score.right : score.wrong);
      }
    }
  }
  return score;
}

TEST(BeamStart, ExactDotsGiveTheExactLines) {
  SyntheticWorld world = testing::synthetic_world(laser_rig_options(40, 1));
  const LaserTruth truth = add_laser(world, {.noise_px = 0.0});
  const BeamStart start = initialize_beams(true_scene(world));
  EXPECT_EQ(score(start, truth).wrong, 0);
  EXPECT_EQ(score(start, truth).missing, 0);
  ASSERT_TRUE(start.grating.has_value());
  int lines = 0;
  for (int beam = 0; beam < 121; ++beam) {
    ASSERT_TRUE(start.lines[beam].has_value());
    lines += motion_between(*truth.lines[beam], *start.lines[beam]).norm() < 1e-6;
  }
  EXPECT_GE(lines, 110);  // those that were hit often enough; the rest is the grating's
}

class BeamLabels : public ::testing::TestWithParam<std::tuple<int, int, double, unsigned>> {};

TEST_P(BeamLabels, AreNeverWrongWithNoiseMissedAndSpuriousDots) {
  const auto [rows, columns, turn, seed] = GetParam();
  SyntheticWorld world = testing::synthetic_world(laser_rig_options(40, seed));
  const LaserTruth truth = add_laser(world, {.grid = {.rows = rows, .columns = columns},
                                             .turn_rad = turn,
                                             .missed_fraction = 0.1,
                                             .spurious_fraction = 0.05,
                                             .seed = seed});
  const BeamStart start = initialize_beams(true_scene(world));
  const Score labels = score(start, truth);
  RecordProperty("right", labels.right);
  EXPECT_EQ(labels.wrong, 0) << labels.right << " right, " << labels.missing << " missing; " << start.origin;
  EXPECT_GE(labels.right, 199 * labels.missing) << start.origin;
  // A dot anywhere in the image is taken for one of 304 beams when it is within 5 sigmas, 0.7 px, of its dot: 0.15 % of
  // the area, or one of these worlds' 200 spurious dots in three worlds.
  EXPECT_LE(labels.chance, 3);
}

INSTANTIATE_TEST_SUITE_P(Grids, BeamLabels,
                         ::testing::Combine(::testing::Values(11, 16), ::testing::Values(11, 19),
                                            ::testing::Values(0.0, 0.21, -0.4), ::testing::Values(1U, 2U)));

// Fewer dots on each beam, so that fewer lines are beyond doubt.
class FewViews : public ::testing::TestWithParam<std::tuple<int, unsigned>> {};

TEST_P(FewViews, LabelMostDotsAndNoneWrong) {
  const auto [columns, seed] = GetParam();
  SyntheticWorld world = testing::synthetic_world(laser_rig_options(14, seed));
  const LaserTruth truth = add_laser(world, {.grid = {.rows = 11, .columns = columns},
                                             .missed_fraction = 0.1,
                                             .spurious_fraction = 0.05,
                                             .brightest_factor = 1.6,
                                             .seed = seed});
  world.problem.laser->brightest = world.problem.laser->grid.index(5, columns / 2);
  const BeamStart start = initialize_beams(true_scene(world));
  const Score labels = score(start, truth);
  EXPECT_EQ(labels.wrong, 0) << labels.right << " right, " << labels.missing << " missing; " << start.origin;
  EXPECT_GE(labels.right, 19 * labels.missing) << start.origin;
  EXPECT_FALSE(start.origin_guessed) << start.origin;
}

INSTANTIATE_TEST_SUITE_P(BeamGrids, FewViews,
                         ::testing::Combine(::testing::Values(11, 19), ::testing::Values(1U, 2U, 3U, 4U, 5U, 6U)));

// Columns run down the image then. Rows and columns are not just exchanged, which would mirror the grid.
TEST(BeamStart, AProjectorMayBeTurnedByAQuarter) {
  SyntheticWorld world = testing::synthetic_world(laser_rig_options(40, 1));
  const LaserTruth truth = add_laser(world, {.grid = {.rows = 16, .columns = 19}, .turn_rad = M_PI / 2});
  const BeamStart start = initialize_beams(true_scene(world));
  EXPECT_EQ(score(start, truth).wrong, 0);
  EXPECT_GE(score(start, truth).right, 100 * score(start, truth).missing);
  EXPECT_NE(start.origin.find("or has the grid 16 columns and 19 rows"), std::string::npos) << start.origin;
}

// Where nothing else does, a few dots whose beams are named say how a projector is turned.
TEST(BeamStart, LabelsSayHowAProjectorIsTurned) {
  for (const double turn_rad : {-M_PI / 2, M_PI / 2, M_PI, 0.2}) {
    SyntheticWorld world = testing::synthetic_world(laser_rig_options(40, 1));
    const LaserTruth truth = add_laser(world, {.grid = {.rows = 16, .columns = 19}, .turn_rad = turn_rad});
    for (std::size_t v = 0; v < 6; ++v) {
      std::vector<Dot>& dots = world.problem.views[v].dots;
      for (std::size_t i = 0; i < dots.size(); i += 9) dots[i].beam = truth.beam_of_dot[v][i];
    }
    const BeamStart start = initialize_beams(true_scene(world));
    EXPECT_EQ(score(start, truth).wrong, 0) << turn_rad;
    EXPECT_GE(score(start, truth).right, 100 * score(start, truth).missing) << turn_rad;
  }
}

TEST(BeamStart, RefusesAGridSmallerThanTheOneSeen) {
  SyntheticWorld world = testing::synthetic_world(laser_rig_options(40, 1));
  add_laser(world, {});
  world.problem.laser->grid = {.rows = 9, .columns = 9};
  EXPECT_THROW(initialize_beams(true_scene(world)), Error);
}

TEST(BeamStart, KeepsTheLabelsThatDotsHave) {
  SyntheticWorld world = testing::synthetic_world(laser_rig_options(12, 4));
  const LaserTruth truth = add_laser(world, {.labelled = true});
  const BeamStart start = initialize_beams(true_scene(world));
  EXPECT_EQ(start.beam_of_dot, truth.beam_of_dot);
}

// Only the middle of the grid is ever seen: then the brightest beam tells which it is.
TEST(BeamStart, TheBrightestBeamFixesTheOrigin) {
  testing::SyntheticOptions options = laser_rig_options(40, 3);
  options.max_off_axis_rad = 0.15;
  options.min_distance_m = 0.7;
  SyntheticWorld world = testing::synthetic_world(options);
  const LaserTruth truth = add_laser(world, {.grid = {.rows = 16, .columns = 19}, .brightest_factor = 3.0});
  world.problem.laser->brightest = world.problem.laser->grid.index(8, 9);
  const BeamStart start = initialize_beams(true_scene(world));
  EXPECT_EQ(start.origin, "the brightest beam");
  EXPECT_EQ(score(start, truth).wrong, 0);
}

TEST(BeamStart, OneClickFixesTheOrigin) {
  testing::SyntheticOptions options = laser_rig_options(40, 3);
  options.max_off_axis_rad = 0.15;
  options.min_distance_m = 0.7;
  SyntheticWorld world = testing::synthetic_world(options);
  const LaserTruth truth = add_laser(world, {.grid = {.rows = 16, .columns = 19}});
  const Dot& dot = world.problem.views[5].dots[3];
  world.problem.laser->anchor = LaserAnchor{5, dot.pixel + Eigen::Vector2d(2, -1), truth.beam_of_dot[5][3]};
  const BeamStart start = initialize_beams(true_scene(world));
  EXPECT_EQ(start.origin, "the anchor");
  EXPECT_EQ(score(start, truth).wrong, 0);
}

TEST(BeamStart, RefusesDotsThatDoNotLineUp) {
  SyntheticWorld world = testing::synthetic_world(laser_rig_options(3, 5));
  add_laser(world, {});
  try {
    initialize_beams(true_scene(world));
    FAIL() << "three poses are too few";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNotEnoughData);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("line up"));
  }
}

}  // namespace
}  // namespace raybundle
