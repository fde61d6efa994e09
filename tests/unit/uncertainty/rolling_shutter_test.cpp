// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/rolling_shutter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/uncertainty/verdict.hpp"
#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;

bool rolls(const CalibrationProblem& problem, const CalibrationResult& result) {
  return is_rolling(row_timings(problem, result, 0));
}

// Reads some views row by row while the board moves with a random velocity, which takes its centre through about
// `sweep_m` and turns it alike, from the first row to the last.
void roll(SyntheticWorld& world, int views, double sweep_m, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Camera& camera = world.cameras[0];
  for (int v = 0; v < views; ++v) {
    TargetView& view = world.problem.views[v];
    const Rigid3& pose = world.poses[world.pose_of_view[v]].rig_from_target;
    Eigen::Matrix<double, 6, 1> velocity;
    for (double& each : velocity) each = normal(random);
    velocity *= sweep_m;
    velocity.head<3>() /= 0.3;  // the board's size: turned about as far as it is moved
    for (Observation& o : view.observations) {
      const Eigen::Vector3d& x = world.problem.targets[0].find(o.point_id)->x_in_target;
      const Eigen::Vector2d still = *pixel_from_ray(camera, pose * x);
      Eigen::Vector2d seen = still;
      for (int iteration = 0; iteration < 5; ++iteration) {
        const double time = seen.y() / camera.size.height - 0.5;
        seen = *pixel_from_ray(camera, perturbed(pose, time * velocity) * x);
      }
      o.pixel += seen - still;
    }
  }
}

TEST(RollingShutter, IsFoundInTheViewsThatMoved) {
  int found = 0, rolled = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SyntheticOptions options = fisheye_options(seed);
    options.noise_px = 0.1;
    options.frames = 30;
    SyntheticWorld world = synthetic_world(options);
    const int views = 8;
    roll(world, views, 0.01, seed);
    const CalibrationResult result = calibrate(world.problem);
    for (const RowTiming& timing : row_timings(world.problem, result, 0)) {
      if (timing.view >= views) {
        EXPECT_FALSE(timing.rows) << timing.view;
        continue;
      }
      ++rolled;
      found += timing.rows;
    }
    const Verdict judged = verdict(world.problem, result, {});
    const auto finding = std::ranges::find(judged.findings, "shutter", &Finding::topic);
    ASSERT_NE(finding, judged.findings.end());
    EXPECT_FALSE(finding->good) << finding->text;
    EXPECT_THAT(finding->text, HasSubstr("rolling shutter"));
  }
  EXPECT_GE(found, 0.4 * rolled) << "of " << rolled;  // what the pose can follow does not show
}

// Noise alone passes the F test once in 1000 views, and then has to be explained by nothing else as well.
TEST(RollingShutter, IsNotFoundInStillViews) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const SyntheticWorld world = synthetic_world(fisheye_options(seed));
    const std::vector<RowTiming> timings = row_timings(world.problem, calibrate(world.problem), 0);
    EXPECT_LE(std::ranges::count_if(timings, &RowTiming::rows), 1);
    EXPECT_FALSE(is_rolling(timings));
  }
}

TEST(RollingShutter, IsNotTakenForALensThatDoesNotFit) {
  SyntheticOptions options = fisheye_options(3);
  options.cameras[0].model = "rational";
  options.cameras[0].focal_px = 700.0;
  options.max_off_axis_rad = 0.5;
  SyntheticWorld world = synthetic_world(options);
  for (const char* model : {"pinhole", "field_of_view", "unified"}) {
    world.problem.cameras[0].model = *model_named(model);
    const CalibrationResult result = calibrate(world.problem);
    EXPECT_FALSE(rolls(world.problem, result)) << model << ", rms " << result.rms_px;
  }
}

// The board bends otherwise in each view, as paper in the hand does: rows and columns fit alike.
TEST(RollingShutter, IsNotTakenForABoardThatIsNotStiff) {
  SyntheticOptions options = fisheye_options(5);
  SyntheticWorld world = synthetic_world(options);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 0.004);
  const Target& target = world.problem.targets[0];
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    const std::vector<Eigen::Vector3d> bent =
        points_on_surface(target, {normal(random), normal(random), normal(random)});
    const Rigid3& pose = world.poses[world.pose_of_view[v]].rig_from_target;
    for (Observation& o : world.problem.views[v].observations) {
      const auto place = static_cast<std::size_t>(target.find(o.point_id) - target.points.data());
      const auto flat = pixel_from_ray(world.cameras[0], pose * target.points[place].x_in_target);
      const auto curved = pixel_from_ray(world.cameras[0], pose * bent[place]);
      if (flat && curved) o.pixel += *curved - *flat;
    }
  }
  const CalibrationResult result = calibrate(world.problem);
  EXPECT_GT(result.rms_px, 0.5);  // the bend is there
  EXPECT_FALSE(rolls(world.problem, result));
}

}  // namespace
}  // namespace raybundle::testing
