// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Exposure control in a closed loop with a simulated sensor.
#include "raybundle/stereo/exposure_control.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "raybundle/geometry/error.hpp"
#include "simulated_sensor.hpp"

namespace raybundle {
namespace {

constexpr ImageSize kSize{64, 48};
constexpr double kTarget = 90.0;
constexpr int kFramesToSettle =
    14;  // 8 stops: three jumps of up to 3 stops, then halves, each with one frame's latency
constexpr double kTolerance = 0.05;

SensorLimits sensor_limits() {
  return {.least_shutter_s = 30e-6,
          .most_shutter_s = 15e-3,
          .shutter_step_s = 30e-6,
          .least_gain = 1.0,
          .most_gain = 16.0,
          .gain_step = 1.0 / 16.0,
          .black_grey = 4.0};
}

// Sensor and control, a frame at a time. The light varies by a factor of two in the image.
struct Loop {
  testing::SimulatedSensor sensor;
  ExposureControl control;
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(static_cast<std::size_t>(kSize.width) * kSize.height);

  explicit Loop(int latency, const std::vector<ExposureArea>& areas = {}, const ExposureOptions& options = {})
      : sensor(sensor_limits(), latency, 1), control(kSize, sensor_limits(), areas, options) {}

  // The median of the image is right with this exposure.
  void light_for(double effective_s) {
    sensor.light.clear();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const double across = static_cast<double>(i % kSize.width) / (kSize.width - 1);
      sensor.light.push_back((kTarget - sensor_limits().black_grey) / effective_s * (2.0 + 2.0 * across) / 3.0);
    }
  }

  ExposureReport frame() {
    const auto taken_with = sensor.capture({pixels.data(), kSize.width, kSize.height, kSize.width});
    const ExposureReport report = control.update({pixels.data(), kSize.width, kSize.height, kSize.width}, *taken_with);
    sensor.set(report.next);
    return report;
  }

  ExposureReport frames(int count) {
    for (int i = 1; i < count; ++i) frame();
    return frame();
  }

  double error(const ExposureReport& report) const {
    return (report.median_grey - kTarget) / (kTarget - sensor_limits().black_grey);
  }
};

struct EachLatency : ::testing::TestWithParam<int> {};

TEST_P(EachLatency, EightStopsTooDarkSettlesAndHolds) {
  Loop loop(GetParam());
  loop.light_for(256 * 30e-6);
  loop.frames(kFramesToSettle);
  for (int i = 0; i < 50; ++i) {
    const ExposureReport report = loop.frame();
    ASSERT_LE(std::abs(loop.error(report)), kTolerance) << i;
    ASSERT_EQ(report.state, State::kOk);
    EXPECT_EQ(report.next.gain, 1.0);  // the shutter alone can do it; a step is 0.4 %
  }
}

TEST_P(EachLatency, EightStopsTooBrightSettlesAndHolds) {
  Loop loop(GetParam());
  loop.light_for(512 * 30e-6 * 16 / 2);
  loop.frames(30);
  loop.light_for(16 * 30e-6);
  EXPECT_EQ(loop.frames(GetParam() + 1).saturated_share, 1.0);
  loop.frames(kFramesToSettle);
  for (int i = 0; i < 50; ++i) {
    const ExposureReport report = loop.frame();
    ASSERT_LE(std::abs(loop.error(report)), kTolerance) << i;
    ASSERT_EQ(report.state, State::kOk);
  }
}

// Latency must not be answered twice: the exposure goes to its goal from one side.
TEST_P(EachLatency, DoesNotOvershoot) {
  Loop loop(GetParam());
  loop.light_for(256 * 30e-6);
  double before_s = 0.0;
  for (int i = 0; i < 40; ++i) {
    const double next_s = loop.frame().next.effective_s();
    EXPECT_LE(next_s, 256 * 30e-6 * (1.0 + kTolerance));
    EXPECT_GE(next_s, before_s * (1.0 - 0.02));  // what is held, plus rounding and noise
    before_s = next_s;
  }
}

INSTANTIATE_TEST_SUITE_P(Latencies, EachLatency, ::testing::Values(0, 1));

TEST(ExposureControl, ADarkSceneEndsAtTheLimitAndSaysSo) {
  Loop loop(1);
  loop.light_for(16 * 15e-3 * 4);
  const ExposureReport report = loop.frames(20);
  EXPECT_EQ(report.state, State::kDegraded);
  EXPECT_TRUE(report.too_dark);
  EXPECT_FALSE(report.settled);
  EXPECT_NEAR(report.next.shutter_s, 15e-3, 1e-9);
  EXPECT_EQ(report.next.gain, 16.0);
  loop.light_for(5e-3);
  EXPECT_EQ(loop.frames(kFramesToSettle).state, State::kOk);
}

TEST(ExposureControl, ASceneOfGlareEndsAtTheLimitAndSaysSo) {
  Loop loop(1);
  loop.light_for(5e-6);
  const ExposureReport report = loop.frames(20);
  EXPECT_EQ(report.state, State::kDegraded);
  EXPECT_TRUE(report.too_bright);
  EXPECT_NEAR(report.next.effective_s(), 30e-6, 1e-12);
}

TEST(ExposureControl, GainComesAfterTheShutter) {
  Loop loop(1);
  loop.light_for(40e-3);
  const ExposureReport report = loop.frames(30);
  EXPECT_NEAR(report.next.shutter_s, 15e-3, 1e-9);
  EXPECT_NEAR(report.next.gain, 40.0 / 15.0, 40.0 / 15.0 * kTolerance);
  EXPECT_LE(std::abs(loop.error(report)), kTolerance);
}

// The median alone would burn out a fifth of the image that is 16 times as bright as the rest.
TEST(ExposureControl, KeepsABrightPartBelowSaturation) {
  Loop loop(1);
  loop.light_for(4e-3);
  for (int i = 0; i < kSize.width * 10; ++i) loop.sensor.light[static_cast<std::size_t>(i)] *= 16.0;
  const ExposureReport report = loop.frames(30);
  EXPECT_TRUE(report.settled);
  EXPECT_LT(report.saturated_share, 0.1);
  EXPECT_LT(report.median_grey, 40.0);
}

TEST(ExposureControl, OnlyTheChosenAreasCount) {
  Loop loop(1, {{0, 0, 64, 8, 0.0}, {0, 40, 64, 8, 1.0}});
  loop.light_for(4e-3);
  for (int i = 0; i < kSize.width * 40; ++i) loop.sensor.light[static_cast<std::size_t>(i)] *= 100.0;
  const ExposureReport report = loop.frames(30);
  EXPECT_LE(std::abs(loop.error(report)), kTolerance);
  EXPECT_EQ(report.saturated_share, 0.0);
}

TEST(ExposureControl, AnExposureIsWithinLimitsAndOnSteps) {
  const SensorLimits limits = sensor_limits();
  for (double wanted_s = 1e-6; wanted_s < 1.0; wanted_s *= 1.07) {
    const Exposure exposure = exposure_of(limits, wanted_s);
    const double shutter_steps = exposure.shutter_s / limits.shutter_step_s;
    const double gain_steps = exposure.gain / limits.gain_step;
    EXPECT_NEAR(shutter_steps, std::round(shutter_steps), 1e-6);
    EXPECT_NEAR(gain_steps, std::round(gain_steps), 1e-6);
    EXPECT_GE(exposure.shutter_s, limits.least_shutter_s);
    EXPECT_LE(exposure.shutter_s, limits.most_shutter_s * (1.0 + 1e-9));
    EXPECT_GE(exposure.gain, limits.least_gain);
    EXPECT_LE(exposure.gain, limits.most_gain);
    if (wanted_s >= 30e-6 && wanted_s <= 0.24) {
      EXPECT_NEAR(exposure.effective_s() / wanted_s, 1.0, 0.5 / 16.0 + 1e-9);  // half a step of gain 1
    }
  }
}

TEST(ExposureControl, AnImageOfAnotherSizeIsInvalidAndChangesNothing) {
  ExposureControl control(kSize, sensor_limits());
  const std::vector<std::uint8_t> pixels(100, 50);
  const ExposureReport report = control.update({pixels.data(), 10, 10, 10}, {1e-3, 1.0});
  EXPECT_EQ(report.state, State::kInvalid);
  EXPECT_EQ(report.next.shutter_s, 30e-6);
}

TEST(ExposureControl, SaysWhatIsWrongAtTheStart) {
  EXPECT_THROW(ExposureControl(kSize, sensor_limits(), {{60, 0, 5, 5, 1.0}}), Error);
  EXPECT_THROW(ExposureControl(kSize, sensor_limits(), {{0, 0, 5, 5, 0.0}}), Error);
  EXPECT_THROW(ExposureControl(kSize, sensor_limits(), {}, {.target_grey = 240.0}), Error);
  EXPECT_THROW(ExposureControl(kSize, SensorLimits{}), Error);
}

}  // namespace
}  // namespace raybundle
