// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/health.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "raybundle/scene/parameter_names.hpp"
#include "raybundle/structured_light/structured_light.hpp"
#include "worlds.hpp"

namespace raybundle {
namespace {

using testing::sensor_world;
using testing::SensorWorld;

// Dots of a projector that was turned after its calibration, in a room of random depths.
std::vector<Dot> dots_of(const SensorWorld& world, const Eigen::Vector3d& turn, Random& random) {
  std::vector<Dot> dots;
  const Eigen::Vector3d centre = world.rig.emitter->rig_from_emitter.translation;
  const double angle = turn.norm();
  const Eigen::Matrix3d turned =
      angle > 0.0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
  for (const EmittedBeam& beam : world.beams) {
    if (!beam.labelled()) continue;
    const Line3 line{centre + turned * (beam.line.point - centre), turned * beam.line.direction};
    const Eigen::Vector3d x_in_camera = world.camera.camera_from_rig * line.at(random.uniform(0.5, 1.2));
    const auto pixel = pixel_from_ray(world.camera.camera, x_in_camera);
    if (!pixel || pixel->x() < 5 || pixel->y() < 5 || pixel->x() > 634 || pixel->y() > 474) continue;
    const double u = 0.1 * random.normal(), v = 0.1 * random.normal();
    dots.push_back({*pixel + Eigen::Vector2d(u, v), 0.01 * Eigen::Matrix2d::Identity()});
  }
  return dots;
}

TEST(Health, StaysQuietWhileNothingChanges) {
  const SensorWorld world = sensor_world({11, 11}, 12.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  StructuredLight sensor(table);
  Random random(2);
  for (int frame = 0; frame < 100; ++frame) {
    const LaserFrame& seen = sensor.process(dots_of(world, Eigen::Vector3d::Zero(), random));
    ASSERT_EQ(seen.state, State::kOk) << "frame " << frame << ", chi-squared " << seen.health.chi_squared;
    EXPECT_NEAR(seen.health.residual_scale, 1.0, 0.2);
  }
}

TEST(Health, TellsATurnOfATwentiethOfAPixelAndKeepsTelling) {
  const SensorWorld world = sensor_world({11, 11}, 12.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  StructuredLight sensor(table);
  Random random(3);
  for (int frame = 0; frame < 20; ++frame) sensor.process(dots_of(world, Eigen::Vector3d::Zero(), random));
  const Eigen::Vector3d turn(0.05 / 282.0, 0, 0);
  State state = State::kOk;
  for (int frame = 0; frame < 10; ++frame) state = sensor.process(dots_of(world, turn, random)).state;
  EXPECT_EQ(state, State::kInvalid);
  const LaserFrame& after = sensor.process(dots_of(world, turn, random));
  EXPECT_NEAR(after.health.turn_rad.x(), turn.x(), 4.0 * after.health.turn_sigma_rad.x());
  for (int frame = 0; frame < 20; ++frame) state = sensor.process(dots_of(world, {0, 0, 0}, random)).state;
  EXPECT_EQ(state, State::kInvalid);  // an alarm stays until the sensor is started again
}

// Beams that are uncertain by more than the turn moves their dots, as errors of a calibration: they hide it from a
// comparison with the calibration, and are learnt while nothing turns.
TEST(Health, LearnsTheBeamsErrorsAndTellsASmallTurn) {
  SensorWorld world = sensor_world({11, 11}, 12.0, 3e-4);
  Random random(6);
  for (LaserBeam& beam : world.calibration.laser->beams) {
    Eigen::Vector4d error;
    for (double& number : error) number = 3e-4 * random.normal();
    beam.line = perturbed(beam.line, error);
  }
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  StructuredLight sensor(table);
  const Eigen::Vector3d still = Eigen::Vector3d::Zero(), turn(0.05 / 282.0, 0, 0);
  for (int frame = 0; frame < 100; ++frame) {
    const LaserFrame& seen = sensor.process(dots_of(world, still, random));
    ASSERT_EQ(seen.state, State::kOk) << "frame " << frame << ", chi-squared " << seen.health.recent_chi_squared;
  }
  LaserFrame seen;
  for (int frame = 0; frame < 10; ++frame) seen = sensor.process(dots_of(world, turn, random));
  EXPECT_EQ(seen.state, State::kInvalid);
  EXPECT_LT(seen.health.chi_squared, seen.health.threshold);
  EXPECT_GT(seen.health.recent_chi_squared, seen.health.threshold);
}

// A camera that is not the rig's first, whose place on the rig is uncertain: all beams seem to have moved together. That
// is no turn of the projector, and hides none that happens later.
TEST(Health, DoesNotTakeAnErrorOfTheCamerasPlaceForATurn) {
  constexpr double kSigma = 3e-4;  // [rad], [m]: what a turn of a tenth of a pixel does
  SensorWorld world = sensor_world({11, 11}, 12.0);
  RigCamera right{"right", world.camera.camera, {}};
  right.camera_from_rig.translation.x() = 0.05;
  world.calibration.cameras.push_back(right);
  world.calibration.covariance = {extrinsic_names(right), kSigma * kSigma * Eigen::MatrixXd::Identity(6, 6)};
  const SensorTable table = sensor_table(world.calibration, "right", {}, "a test");
  Random random(9);
  for (int place = 0; place < 5; ++place) {
    Eigen::Matrix<double, 6, 1> error;
    for (double& number : error) number = kSigma * random.normal();
    world.camera = {"right", right.camera, perturbed(right.camera_from_rig, error)};
    StructuredLight sensor(table);
    for (int frame = 0; frame < 50; ++frame) {
      const LaserFrame& seen = sensor.process(dots_of(world, Eigen::Vector3d::Zero(), random));
      ASSERT_EQ(seen.health.state, State::kOk) << "place " << place << ", frame " << frame << ", chi-squared "
                                               << seen.health.chi_squared << ", " << seen.health.recent_chi_squared;
    }
    State state = State::kOk;
    for (int frame = 0; frame < 10; ++frame) state = sensor.process(dots_of(world, {0.05 / 282.0, 0, 0}, random)).state;
    EXPECT_EQ(state, State::kInvalid) << place;
  }
}

TEST(BeamMemory, BeginsWithTheCalibrationAndComesToWhatItSees) {
  const SensorTable table = sensor_table(sensor_world({11, 11}, 12.0, 1e-3).calibration, "", {}, "a test");
  const BeamSet beams(table);
  BeamMemory memory(beams, 300);
  constexpr int kBeam = 40;
  const auto along = [](int i) { return i % 2 == 0 ? -0.2 : 0.3; };  // places where dots are seen [m]
  const double calibrated = beams.beams[kBeam].off_plane_variance(0.3, 2.0);
  EXPECT_EQ(memory.off(kBeam, 0.3, 2.0).mean, 0.0);
  EXPECT_NEAR(memory.off(kBeam, 0.3, 2.0).variance, calibrated, 1e-9);
  EXPECT_LT((memory.off(kBeam, 0.3, 2.0).by_calibration - Eigen::RowVector2d(2.0, 0.3 * 2.0)).norm(), 1e-9);
  Random random(8);
  constexpr double kSigma = 3e-4;
  for (int i = 0; i < 200; ++i) {
    memory.fade();
    const double off = 2.0 * (4e-4 - 1e-3 * along(i));
    memory.learn(kBeam, along(i), 2.0, off + kSigma * random.normal(), kSigma * kSigma);
  }
  const BeamMemory::Off off = memory.off(kBeam, 0.1, 2.0);  // at another place
  EXPECT_NEAR(off.mean, 2.0 * (4e-4 - 1e-3 * 0.1), 4.0 * std::sqrt(off.variance));
  EXPECT_LT(off.variance, 0.02 * kSigma * kSigma);
  EXPECT_LT(off.by_calibration.norm(), 0.02);  // its errors are learnt, whatever they are
  for (int i = 0; i < 10000; ++i) memory.fade();
  EXPECT_NEAR(memory.off(kBeam, 0.3, 2.0).variance, calibrated, 1e-9);
}

// A false alarm stays until the next start, so it is the life of a car that counts, not an hour.
TEST(Health, IsStatedToRaiseNoFalseAlarmInTheLifeOfACar) {
  constexpr double kFrames = 20.0 * 3600.0 * 6000.0;  // twenty a second, 6000 hours of driving
  EXPECT_LE(HealthOptions{}.false_alarm_rate * kFrames, 0.05);
  const SensorTable table = sensor_table(sensor_world({11, 11}, 12.0).calibration, "", {}, "a test");
  const BeamSet beams(table);
  EXPECT_NEAR(Health(beams, {}).report().threshold, 51.0, 0.1);  // 5e-11 of the law of three degrees lie above
}

TEST(Health, IsDegradedWithoutDots) {
  const SensorWorld world = sensor_world({11, 11}, 12.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  const BeamSet beams(table);
  Health health(beams, {});
  EXPECT_EQ(health.update({}).state, State::kDegraded);
}

}  // namespace
}  // namespace raybundle
