// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Rigs of which a camera drops out, and rigs whose board is bent.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "rig_worlds.hpp"

namespace raybundle {
namespace {

using testing::stereo;
using testing::synthetic_world;
using testing::SyntheticCamera;
using testing::SyntheticOptions;
using testing::SyntheticWorld;
using testing::three_cameras;

// Every third frame is one camera's alone.
void unlink(int camera, CalibrationProblem& problem) {
  std::erase_if(problem.views,
                [&](const TargetView& view) { return (view.frame % 3 == 0) != (view.camera == camera); });
}

// One camera with too few views is named and left out; the rest of the rig is calibrated.
TEST(Rig, OneBadCameraDoesNotCostTheRig) {
  SyntheticOptions options = three_cameras(9);
  SyntheticWorld world = synthetic_world(options);
  int left = 1;
  std::erase_if(world.problem.views, [&](const TargetView& view) { return view.camera == 2 && left-- <= 0; });
  const CalibrationResult result = calibrate(world.problem);
  EXPECT_THAT(result.calibration.cameras, ::testing::SizeIs(2));
  EXPECT_THAT(result.cameras, ::testing::SizeIs(3));
  EXPECT_EQ(result.cameras[2].views_used, 0);
  EXPECT_THAT(result.warnings, ::testing::Contains(::testing::HasSubstr("camera2")));
}

// A camera that never sees a board together with another one is calibrated well, but has no place: that is said.
TEST(Rig, OneCameraWithFramesOfItsOwnIsNamedAsNotLinked) {
  SyntheticOptions options = three_cameras(23);
  SyntheticWorld world = synthetic_world(options);
  std::erase_if(world.problem.views,
                [](const TargetView& view) { return (view.frame % 3 == 0) != (view.camera == 2); });
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_THAT(result.calibration.cameras, ::testing::SizeIs(2));
  EXPECT_THAT(result.warnings, ::testing::Contains(::testing::HasSubstr(
                                   "camera2 is left out: in no frame does it see a board together with another")));
  EXPECT_EQ(std::ranges::count(result.set_aside, "its camera shares no frame with the others", &SetAside::reason),
            std::ranges::count(world.problem.views, 2, &TargetView::camera));
}

TEST(Rig, TellsWhichCameraIsNotLinked) {
  SyntheticWorld world = synthetic_world(stereo(11));
  std::erase_if(world.problem.views, [](const TargetView& view) { return view.frame % 2 != view.camera; });
  try {
    calibrate(world.problem);
    FAIL() << "expected an error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNotEnoughData);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("camera1"));
  }
}

// Extrinsics are given in the frame of the first camera; when that one drops out, the next one's frame takes its place.
TEST(Rig, GivenExtrinsicsSurviveTheLossOfTheFirstCamera) {
  SyntheticOptions options = three_cameras(17);
  SyntheticWorld world = synthetic_world(options);
  for (std::size_t c = 0; c < 3; ++c) world.problem.cameras[c].camera_from_rig = world.camera_from_rig[c];
  world.problem.rules = {{"*.camera_from_rig", ParameterRule::Kind::kFixed, {}, 0.0}};
  std::erase_if(world.problem.views, [](const TargetView& view) { return view.camera == 0; });
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_THAT(result.calibration.cameras, ::testing::SizeIs(2));
  const Rigid3 truth = world.camera_from_rig[2] * world.camera_from_rig[1].inverse();
  EXPECT_LT(motion_between(truth, result.calibration.cameras[1].camera_from_rig).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(result.rms_px, 1e-6);  // exact observations
}

// Start values that no view fits: the camera was taken for calibrated, its rms for 0, and its place for known.
TEST(Rig, ACameraWhoseStartFitsNoViewIsLeftOut) {
  SyntheticWorld world = synthetic_world(three_cameras(17));
  for (std::size_t c = 0; c < 3; ++c) {
    world.problem.cameras[c].parameters = world.cameras[c].parameters;
    world.problem.cameras[c].camera_from_rig = world.camera_from_rig[c];
  }
  world.problem.cameras[1].parameters->head<4>() << 100.0, 100.0, 3000.0, 480.0;
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_THAT(result.calibration.cameras, ::testing::SizeIs(2));
  EXPECT_THAT(result.warnings, ::testing::Contains(::testing::HasSubstr("camera camera1: none of its ")));
  EXPECT_EQ(result.cameras[1].views_used, 0);
  for (const int good : {0, 2}) {
    EXPECT_LT(result.cameras[good].rms_px, 1e-6) << good;
    EXPECT_TRUE(std::isfinite(result.cameras[good].sigma_scale)) << good;
  }
  std::erase_if(world.problem.views, [](const TargetView& view) { return view.camera == 1; });
  EXPECT_THAT(calibrate(world.problem).warnings,
              ::testing::Contains(::testing::HasSubstr("camera camera1: there is no view of the board")));
  world.problem.cameras = {world.problem.cameras[1]};
  CalibrationProblem alone = synthetic_world({}).problem;
  alone.cameras[0].parameters = world.problem.cameras[0].parameters;
  try {
    calibrate(alone);
    FAIL() << "expected an error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("none of its 20 views fits the lens that it started from"));
  }
}

// A place that is to stay where the start has it cannot be told from another camera whose own place is not known.
TEST(Rig, PlacesKeptAtTheStartAreNotUsedWithoutTheFirstCamera) {
  SyntheticWorld world = synthetic_world(three_cameras(17));
  world.problem.cameras[2].camera_from_rig = world.camera_from_rig[2];
  world.problem.rules = {{"camera2.camera_from_rig", ParameterRule::Kind::kFixed, {}, 0.0}};
  std::erase_if(world.problem.views, [](const TargetView& view) { return view.camera == 0; });
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_THAT(result.calibration.cameras, ::testing::SizeIs(2));
  EXPECT_THAT(result.warnings, ::testing::Contains(::testing::HasSubstr("camera2.camera_from_rig is not used")));
  const Rigid3 truth = world.camera_from_rig[2] * world.camera_from_rig[1].inverse();
  EXPECT_LT(motion_between(truth, result.calibration.cameras[1].camera_from_rig).cwiseAbs().maxCoeff(), 1e-8);
}

// A lens whose model has priors is left out with them.
TEST(Rig, ACameraThatIsNotLinkedTakesItsLensPriorsAlong) {
  SyntheticOptions options = three_cameras(23);
  options.noise_px = 0.2;
  for (SyntheticCamera& camera : options.cameras) {
    camera.model = "rational";
    camera.focal_px = 700.0;
  }
  SyntheticWorld world = synthetic_world(options);
  unlink(2, world.problem);
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_THAT(result.calibration.cameras, ::testing::SizeIs(2));
  EXPECT_THAT(result.warnings, ::testing::Contains(::testing::HasSubstr("camera2 is left out")));
}

// A place that is given as seen from a camera says nothing without it.
TEST(Rig, PlacesGivenAgainstALeftOutCameraAreNotUsed) {
  SyntheticOptions options = three_cameras(17);
  options.noise_px = 0.1;
  SyntheticWorld world = synthetic_world(options);
  const double x_m = world.camera_from_rig[2].translation.x();
  world.problem.rules = {{"camera2.camera_from_rig.translation_x", ParameterRule::Kind::kPrior, x_m, 1e-4},
                         {"camera1.camera_from_rig.translation_x", ParameterRule::Kind::kFixed,
                          world.camera_from_rig[1].translation.x(), 0}};
  unlink(0, world.problem);
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_THAT(result.calibration.cameras, ::testing::SizeIs(2));
  EXPECT_THAT(result.warnings, ::testing::Contains(::testing::HasSubstr(
                                   "camera2.camera_from_rig.translation_x is not used: it is given as seen from "
                                   "camera camera0, which is left out")));
  const Rigid3 truth = world.camera_from_rig[2] * world.camera_from_rig[1].inverse();
  const auto motion = motion_between(truth, result.calibration.cameras[1].camera_from_rig);
  EXPECT_LT(motion.tail<3>().norm(), 1e-3);  // several sigmas; off by a tenth of a metre before
}

// Taken for flat, a bent board seems to have moved between the exposures of cameras that see it from several sides.
TEST(Rig, ABentBoardTiesTheCamerasInEveryFrame) {
  for (const double bend_m : {0.0005, 0.001, 0.003, 0.006}) {
    SyntheticOptions options = three_cameras(29);
    options.noise_px = 0.1;
    options.shape.bend_x_m = bend_m;
    CalibrationProblem problem = synthetic_world(options).problem;
    for (const bool given : {false, true}) {
      if (given) problem.rules = {{"board0.bend_x", ParameterRule::Kind::kFixed, bend_m, 0.0}};
      const CalibrationResult result = calibrate(problem);
      EXPECT_THAT(result.set_aside, ::testing::IsEmpty()) << bend_m << given;
      EXPECT_THAT(result.warnings, ::testing::Not(::testing::Contains(::testing::HasSubstr("moved"))))
          << bend_m << given;
      EXPECT_NEAR(result.calibration.targets[0].shape.bend_x_m, bend_m, 5e-5) << bend_m << given;
    }
  }
}

// A blurred camera beside a sharp one takes nothing away from what that one says of itself.
TEST(Rig, EachCameraCountsByItsOwnNoise) {
  SyntheticOptions options = three_cameras(31);
  SyntheticWorld world = synthetic_world(options);
  const double noise_px[] = {0.03, 0.3, 0.1};
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (TargetView& view : world.problem.views) {
    for (Observation& seen : view.observations) {
      seen.pixel += noise_px[view.camera] * Eigen::Vector2d(normal(random), normal(random));
    }
  }
  const CalibrationResult rig = calibrate(world.problem);
  for (std::size_t c = 0; c < 3; ++c) {  // the noise of some thousand corners is known to a few percent
    EXPECT_NEAR(rig.cameras[c].sigma_scale / rig.cameras[2].sigma_scale, noise_px[c] / noise_px[2],
                0.1 * noise_px[c] / noise_px[2]);
  }
  CalibrationProblem alone = world.problem;
  std::erase_if(alone.views, [](const TargetView& view) { return view.camera != 0; });
  alone.cameras.resize(1);
  EXPECT_LT(rig.calibration.covariance.sigma("camera0.fx"),
            1.05 * calibrate(alone).calibration.covariance.sigma("camera0.fx"));
  EXPECT_LT(std::abs(rig.calibration.cameras[0].camera.fx() - world.cameras[0].fx()),
            4.0 * rig.calibration.covariance.sigma("camera0.fx"));
}

}  // namespace
}  // namespace raybundle
