// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "laser_world.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {
namespace {

using testing::add_laser;
using ::testing::HasSubstr;
using testing::laser_rig_options;
using testing::LaserOptions;
using testing::LaserTruth;
using testing::synthetic_world;
using testing::SyntheticWorld;

/// Wrong labels, and how far the beams are from the truth at their own points.
struct Errors {
  int wrong_labels = 0;
  int spurious_used = 0;  ///< dots that no beam made, but that lie where one that was missed would have been
  double farthest_m = 0.0;
  double mean_squared_sigmas = 0.0;
};

Errors errors_of(const LaserTruth& truth, const CalibrationResult& result) {
  Errors errors;
  for (std::size_t v = 0; v < truth.beam_of_dot.size(); ++v) {
    for (std::size_t i = 0; i < truth.beam_of_dot[v].size(); ++i) {
      const int beam = result.views[v].beam_of_dot[i], made_by = truth.beam_of_dot[v][i];
      const bool used = result.views[v].dot_fates[i] == ObservationFate::kUsed;
      errors.wrong_labels += made_by != kUnlabelled && beam != kUnlabelled && beam != made_by;
      errors.spurious_used += made_by == kUnlabelled && used;
    }
  }
  const LaserPattern& pattern = *result.calibration.laser;
  int strong = 0;
  for (const LaserBeam& beam : pattern.beams) {
    const Eigen::Vector4d motion = motion_between(beam.line, *truth.lines[pattern.grid.index(beam.row, beam.column)]);
    errors.farthest_m = std::max(errors.farthest_m, motion.head<2>().norm());
    if (beam.hits < 4) continue;  // they lean on the grating's model, which errs as it errs
    errors.mean_squared_sigmas += motion.dot(beam.covariance.ldlt().solve(motion)) / 4.0;
    ++strong;
  }
  errors.mean_squared_sigmas /= std::max(1, strong);
  return errors;
}

TEST(CalibrateLaser, ExactDotsGiveTheExactBeams) {
  SyntheticWorld world = synthetic_world(laser_rig_options(30, 4));
  const LaserTruth truth = add_laser(world, {.noise_px = 0, .brightest_factor = 2.0, .seed = 4});
  world.problem.laser->brightest = 60;
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_TRUE(result.calibration.laser && result.laser);
  EXPECT_GT(result.calibration.laser->beams.size(), 110u);
  const Errors errors = errors_of(truth, result);
  EXPECT_EQ(errors.wrong_labels, 0);
  EXPECT_LT(errors.farthest_m, 1e-7);  // the dots state 0.1 px, of which a millionth is left
}

// A few labels say which beam is which, and leave the others to be found.
TEST(CalibrateLaser, AFewLabelledBeamsLabelAll) {
  SyntheticWorld exact = synthetic_world(laser_rig_options(30, 4));
  const LaserTruth truth = add_laser(exact, {.noise_px = 0, .seed = 4});
  const auto label = [&](CalibrationProblem& problem, auto&& is_labelled) {
    for (std::size_t v = 0; v < problem.views.size(); ++v) {
      for (std::size_t i = 0; i < truth.beam_of_dot[v].size(); ++i) {
        const int beam = truth.beam_of_dot[v][i];
        if (beam != kUnlabelled && is_labelled(beam / 11, beam % 11)) problem.views[v].dots[i].beam = beam;
      }
    }
  };
  const std::vector<std::function<bool(int, int)>> some{
      [](int row, int column) { return row == 5 && column == 5; },
      [](int row, int column) { return std::abs(row - 5) < 2 && std::abs(column - 5) < 2; },
      [](int, int column) { return column == 5; }};
  for (std::size_t k = 0; k < some.size(); ++k) {
    CalibrationProblem problem = exact.problem;
    label(problem, some[k]);
    const CalibrationResult result = calibrate(problem);
    ASSERT_TRUE(result.calibration.laser && result.laser) << k;
    EXPECT_GT(result.calibration.laser->beams.size(), 110u) << k;
    EXPECT_EQ(errors_of(truth, result).wrong_labels, 0) << k;
  }
}

// The scatter of the beams is what their covariance says; the mean over 121 beams that share one camera lies within 25
// % for all but one seed in thousands.
TEST(CalibrateLaser, NoisyDotsScatterAsTheirCovarianceSaysAndDragNothing) {
  testing::SyntheticOptions options = laser_rig_options(40, 5);
  options.noise_px = 0.1;
  SyntheticWorld world = synthetic_world(options);
  const LaserTruth truth = add_laser(world, {.missed_fraction = 0.1, .brightest_factor = 2.0, .seed = 6});
  world.problem.laser->brightest = 60;
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_TRUE(result.calibration.laser && result.laser);
  const Errors errors = errors_of(truth, result);
  EXPECT_EQ(errors.wrong_labels, 0);
  EXPECT_NEAR(std::sqrt(errors.mean_squared_sigmas), 1.0, 0.25);
  EXPECT_LT(drag_sigmas(result.laser->parameters), 4.0);
  EXPECT_NEAR(result.laser->sigma_scale, 1.0, 0.1);
  for (const LaserBeam& beam : result.calibration.laser->beams) {
    if (beam.hits < 6) continue;
    EXPECT_GT(beam.depths[2].sigma_m, 1e-4);  // at 1 m; the dots' own noise allows no less than tenths of a millimetre
    EXPECT_LT(beam.depths[2].sigma_m, 5e-2);
  }
  EXPECT_TRUE(result.calibration.laser->advice);
}

TEST(CalibrateLaser, DotsThatNoBeamMadeAreLeftOutAndMislabelNothing) {
  testing::SyntheticOptions options = laser_rig_options(40, 5);
  options.noise_px = 0.1;
  SyntheticWorld world = synthetic_world(options);
  const LaserTruth truth =
      add_laser(world, {.missed_fraction = 0.1, .spurious_fraction = 0.05, .brightest_factor = 2.0, .seed = 6});
  world.problem.laser->brightest = 60;
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_TRUE(result.calibration.laser && result.laser);
  const Errors errors = errors_of(truth, result);
  EXPECT_EQ(errors.wrong_labels, 0);
  EXPECT_LE(errors.spurious_used, 3);  // of about a hundred: where a beam was missed, and as near as its dot would be
}

TEST(CalibrateLaser, WithFixedCamerasOnlyBoardsAndBeamsMove) {
  SyntheticWorld world = synthetic_world(laser_rig_options(30, 8));
  add_laser(world, {.labelled = true, .seed = 8});
  world.problem.cameras[0].parameters = world.cameras[0].parameters;
  world.problem.rules.push_back({"*.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0});
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_TRUE(result.calibration.laser);
  EXPECT_EQ(result.calibration.cameras[0].camera.parameters, world.cameras[0].parameters);
  EXPECT_TRUE(result.laser->parameters.empty());
}

TEST(CalibrateLaser, TooFewDotsCostTheBeamsButNotTheCameras) {
  SyntheticWorld world = synthetic_world(laser_rig_options(20, 9));
  add_laser(world, {.seed = 9});
  for (TargetView& view : world.problem.views) view.dots.resize(std::min<std::size_t>(view.dots.size(), 1));
  const CalibrationResult result = calibrate(world.problem);
  EXPECT_FALSE(result.calibration.laser);
  EXPECT_EQ(result.termination, Termination::kConverged);
  EXPECT_THAT(result.warnings, ::testing::Contains(HasSubstr("beams could not be calibrated")));
}

// The anchor names its view by number, and dots and views may come in any order.
TEST(CalibrateLaser, TheOrderOfViewsAndDotsDoesNotMatter) {
  SyntheticWorld world = synthetic_world(laser_rig_options(24, 10));
  const LaserTruth truth = add_laser(world, {.seed = 10});
  const int anchored = 5;
  ASSERT_FALSE(world.problem.views[anchored].dots.empty());
  world.problem.laser->anchor =
      LaserAnchor{anchored, world.problem.views[anchored].dots[0].pixel, truth.beam_of_dot[anchored][0]};
  CalibrationProblem reversed = world.problem;
  std::ranges::reverse(reversed.views);
  for (TargetView& view : reversed.views) std::ranges::reverse(view.dots);
  reversed.laser->anchor->view = static_cast<int>(reversed.views.size()) - 1 - anchored;
  const CalibrationResult one = calibrate(world.problem), other = calibrate(reversed);
  ASSERT_TRUE(one.calibration.laser && other.calibration.laser);
  ASSERT_EQ(one.calibration.laser->beams.size(), other.calibration.laser->beams.size());
  for (std::size_t b = 0; b < one.calibration.laser->beams.size(); ++b) {
    EXPECT_EQ(one.calibration.laser->beams[b].line.direction, other.calibration.laser->beams[b].line.direction);
  }
  EXPECT_EQ(errors_of(truth, one).wrong_labels, 0);
}

}  // namespace
}  // namespace raybundle
