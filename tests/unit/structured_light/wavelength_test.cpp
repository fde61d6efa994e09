// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>

#include "raybundle/structured_light/structured_light.hpp"
#include "worlds.hpp"

namespace raybundle {
namespace testing {
extern std::atomic<long> heap_calls;  // of this binary: heap_calls.hpp
}

namespace {

using testing::CabinScene;
using testing::emitted_by;
using testing::grating_world;
using testing::SceneDot;
using testing::SensorWorld;

constexpr double kPerKelvin = 0.28 / 830.0;  // of ln(wavelength), a laser diode

std::vector<SceneDot> seen(const SensorWorld& world, double warmer_K, int scene) {
  Random random(5, scene);
  const LaserPattern& laser = *world.calibration.laser;
  return dots_in(CabinScene(scene), world.camera, emitted_by(laser, warmer_K * kPerKelvin), laser.grid, {}, random);
}

std::vector<Dot> plain(const std::vector<SceneDot>& dots) {
  std::vector<Dot> plain;
  for (const SceneDot& dot : dots) plain.push_back(dot.dot);
  return plain;
}

struct Count {
  int right = 0, wrong = 0, possible = 0, covered = 0;
};

void add(const SensorTable& table, const std::vector<SceneDot>& dots, const LaserFrame& frame, Count& count) {
  for (const SceneDot& dot : dots) {
    const double depth = dot.x_in_camera.z();
    count.possible += dot.beam >= 0 && depth >= table.range.nearest_m && depth <= table.range.farthest_m;
  }
  for (const LaserPoint& point : frame.points) {
    const SceneDot& dot = dots[point.dot];
    const bool right = dot.beam == frame.dots[point.dot].beam;
    right ? ++count.right : ++count.wrong;
    const double error = std::abs(point.x_in_camera.z() - dot.x_in_camera.z());
    count.covered += right && error <= 3.0 * std::sqrt(point.covariance(2, 2));
  }
}

TEST(Wavelength, OfALaserThatIsStartedHotOrColdIsFoundInTheFirstFrame) {
  const SensorWorld world = grating_world({11, 11}, 13.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  for (const double warmer_K : {0.0, 10.0, -25.0, 40.0, -40.0, 60.0}) {
    Count count;
    for (int s = 0; s < 5; ++s) {
      StructuredLight sensor(table);
      const auto dots = seen(world, warmer_K, s);
      const LaserFrame& frame = sensor.process(plain(dots));
      EXPECT_NE(frame.health.state, State::kInvalid) << warmer_K << " K: no turn";
      EXPECT_NEAR(frame.health.log_wavelength, warmer_K * kPerKelvin, 2.0 * kPerKelvin) << warmer_K << " K";
      add(table, dots, frame, count);
    }
    EXPECT_LE(count.wrong, 2) << warmer_K << " K";  // ./dev prove warmth has the figures
    EXPECT_GE(count.right, 0.97 * count.possible) << warmer_K << " K";
    EXPECT_GE(count.covered, 0.98 * count.right) << warmer_K << " K";
  }
}

// Too few to find the wavelength by: what is labelled is right, and its covariance holds the error of depth.
TEST(Wavelength, ThatIsNotKnownWidensGatesAndCovariances) {
  const SensorWorld world = grating_world({11, 11}, 13.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  Count count;
  for (int s = 0; s < 10; ++s) {
    std::vector<SceneDot> few = seen(world, 20.0, s);
    few.resize(25);
    StructuredLight sensor(table);
    const LaserFrame& frame = sensor.process(plain(few));
    EXPECT_EQ(frame.state, State::kDegraded);
    add(table, few, frame, count);
  }
  EXPECT_LE(count.wrong, 2);
  EXPECT_GE(count.right,
            0.75 * count.possible);  // where gates are wide, more is left open; with narrow ones it was a half
  EXPECT_GE(count.covered, 0.98 * count.right);
}

TEST(Wavelength, IsTakenAsKnownWhenItIsNotFollowed) {
  const SensorWorld world = grating_world({11, 11}, 13.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  StructuredLight following(table), held(table, {.dots = {}, .health = {}, .follow_wavelength = false});
  Count warm, cold, calibrated;
  const auto dots = seen(world, 40.0, 1), as_calibrated = seen(world, 0.0, 1);
  add(table, dots, following.process(plain(dots)), warm);
  add(table, dots, held.process(plain(dots)), cold);
  add(table, as_calibrated, held.process(plain(as_calibrated)), calibrated);
  EXPECT_LT(2 * cold.right, warm.right);
  EXPECT_GE(calibrated.right, 0.97 * calibrated.possible);
}

TEST(Wavelength, MovesPointsAsTheirCovarianceSays) {
  const SensorWorld world = grating_world({11, 11}, 12.0, 0.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  const TableBeam& beam = table.beams[14];
  const Eigen::Vector3d x = beam.line.at((0.8 - beam.line.point.z()) / beam.line.direction.z());
  const Eigen::Vector2d pixel = *pixel_from_ray(world.camera.camera, x);
  constexpr double kSigma = 1e-4;
  const LaserPoint point =
      laser_point(beam, beam_geometry(beam), table.rays.at(pixel), Eigen::Matrix2d::Zero(), kSigma * kSigma);
  // The same dot by a beam that a sigma has moved: one direction, to first order.
  const LaserPoint moved =
      laser_point(beam, beam_geometry(beam, kSigma), table.rays.at(pixel), Eigen::Matrix2d::Zero(), 0.0);
  const Eigen::Vector3d by = moved.x_in_camera - point.x_in_camera;
  EXPECT_GT(by.norm(), 1e-4);
  EXPECT_LT((point.covariance - by * by.transpose()).norm(), 0.02 * by.squaredNorm());
}

TEST(Wavelength, WithinSixtyKelvinFindsEveryBeamInTheLists) {
  const SensorWorld world = grating_world({16, 19}, 14.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  Random random(3);
  int seen_dots = 0;
  for (int i = 0; i < 5000; ++i) {
    const int beam = random.below(static_cast<int>(table.beams.size()));
    const double log_wavelength = random.uniform(-60.0, 60.0) * kPerKelvin;
    const Line3 line = emitted_by(*world.calibration.laser, log_wavelength)[beam].line;
    const double depth = 1.0 / random.uniform(1.0 / 1.5, 1.0 / 0.15);
    const auto pixel = pixel_from_ray(world.camera.camera, line.at((depth - line.point.z()) / line.direction.z()));
    if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 639 || pixel->y() > 479) continue;
    ++seen_dots;
    EXPECT_EQ(std::ranges::count(table.candidates.at(*pixel), beam), 1) << "beam " << beam << " at " << depth << " m";
  }
  EXPECT_GT(seen_dots, 2000);
}

TEST(Wavelength, IsFoundWithoutMemory) {
  const SensorWorld world = grating_world({11, 11}, 13.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  const std::vector<Dot> dots = plain(seen(world, 30.0, 2));
  StructuredLight sensor(table);
  const long before = testing::heap_calls;
  const std::size_t points = sensor.process(dots).points.size();
  EXPECT_EQ(testing::heap_calls - before, 0);
  EXPECT_GT(points, 50U);
}

}  // namespace
}  // namespace raybundle
