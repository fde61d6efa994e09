// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "render_rigs.hpp"

namespace raybundle::testing {
namespace {

// One beam straight ahead onto a white board.
SimulatedRig spot_rig(double focal_px) {
  SimulatedRig rig = board_rig(small_camera("pinhole", focal_px));
  rig.board.print.boxes.clear();
  Emitter emitter;
  emitter.grid = {3, 3};
  emitter.beam_power_W = 40e-6;
  emitter.column_period_m = emitter.row_period_m = 8e-6;
  emitter.zero_order_row = emitter.zero_order_column = 1;
  emitter.rig_from_emitter.translation = {0.06, 0.013, 0};
  rig.emitter = emitter;
  return rig;
}

template <typename Visit>
void for_each_pixel_near(const Eigen::Vector2d& near, Visit&& visit) {
  constexpr int kReach = 8;
  const Eigen::Vector2i at = near.array().round().cast<int>();
  for (int y = at.y() - kReach; y <= at.y() + kReach; ++y) {
    for (int x = at.x() - kReach; x <= at.x() + kReach; ++x) visit(x, y);
  }
}

// Centroid of on minus off within some pixels of a dot.
Eigen::Vector2d centroid(const RenderedView& view, const Eigen::Vector2d& near) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0;
  for_each_pixel_near(near, [&](int x, int y) {
    const double light = view.on.at(x, y) - view.off.at(x, y);
    sum += light * Eigen::Vector2d(x, y);
    weight += light;
  });
  return sum / weight;
}

// Sum of on minus off within some pixels of a dot.
double spot_sum(const RenderedView& view, const Eigen::Vector2d& near) {
  double sum = 0;
  for_each_pixel_near(near, [&](int x, int y) { sum += view.on.at(x, y) - view.off.at(x, y); });
  return sum;
}

constexpr RenderOptions kExact{.noise = false, .speckle = false};

// What remains is rounding to 12 bits in the outer parts of the spot, and that perspective moves the centre of a spot
// of 1 mm by up to 0.003 px.
TEST(Render, SpotsAreCentredWhereBeamsMeetTheBoard) {
  const ViewRenderer renderer(spot_rig(170));
  int checked = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& turned_deg :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(30, 0, 10), Eigen::Vector3d(-20, 35, 0)}) {
    const RenderedView view = renderer.render(0, pose_at({0.06, 0.01, 0.4}, turned_deg), kExact);
    for (const RenderedDot& dot : view.dots) {
      if (!dot.on_board) continue;
      const Eigen::Vector2d error = centroid(view, dot.pixel) - dot.pixel;
      EXPECT_LT(error.norm(), 0.02);
      mean += error;
      ++checked;
    }
  }
  EXPECT_EQ(checked, 27);
  EXPECT_LT((mean / checked).norm(), 0.003);
}

// The power of a beam arrives on the sensor, whatever the spot's shape; on ink, less by the albedos' ratio.
TEST(Render, SpotsHoldTheBeamsPower) {
  SimulatedRig rig = spot_rig(170);
  rig.cameras[0].sensor.vignetting = 0;
  const Rigid3 pose = pose_at({0.06, 0.01, 0.4}, {0, 0, 0});
  const RenderedView view = render_view(rig, 0, pose, kExact);
  rig.board.print.boxes = {rig.board.print.sheet};
  const RenderedView inked = render_view(rig, 0, pose, kExact);
  ASSERT_EQ(view.dots.size(), 9u);
  ASSERT_EQ(inked.dots.size(), 9u);
  for (std::size_t i = 0; i < view.dots.size(); ++i) {
    const Camera& camera = rig.cameras[0].camera;
    const double pixel_m2 = 0.4 * 0.4 / (camera.fx() * camera.fy());  // of a pinhole on a board across its axis
    const double expected = 4095 * rig.board.paper_albedo * rig.emitter->beam_power_W / pixel_m2 / 8.0;
    const double power = view.dots[i].beam == 4 ? rig.emitter->zero_order_power : 1.0;
    EXPECT_NEAR(spot_sum(view, view.dots[i].pixel), power * expected, 0.01 * expected);
    EXPECT_NEAR(spot_sum(inked, view.dots[i].pixel) / spot_sum(view, view.dots[i].pixel),
                rig.board.ink_albedo / rig.board.paper_albedo, 0.005);
    EXPECT_TRUE(inked.dots[i].on_ink);
    EXPECT_FALSE(view.dots[i].on_ink);
  }
}

TEST(Render, OnMinusOffIsTheLaserAndNothingElse) {
  SimulatedRig rig = spot_rig(170);
  rig.board = board_rig(rig.cameras[0].camera).board;
  rig.emitter->rig_from_emitter.translation = {0.005, 0, 0};  // the board hides no spot
  rig.light.sun_W_m2 = 2;
  const RenderedView view = render_view(rig, 0, pose_at({-0.1, 0.01, 0.4}, {20, 30, 0}), kExact);
  EXPECT_GT(std::ranges::count(view.dots, true, &RenderedDot::on_board), 0);
  EXPECT_GT(std::ranges::count(view.dots, false, &RenderedDot::on_board), 0);
  for (int y = 0; y < view.on.size.height; ++y) {
    for (int x = 0; x < view.on.size.width; ++x) {
      const bool spot = std::ranges::any_of(
          view.dots, [&](const RenderedDot& dot) { return (dot.pixel - Eigen::Vector2d(x, y)).norm() < 8; });
      ASSERT_TRUE(spot ? view.on.at(x, y) >= view.off.at(x, y) : view.on.at(x, y) == view.off.at(x, y))
          << "pixel " << x << " " << y << " " << view.on.at(x, y) << " " << view.off.at(x, y);
    }
  }
  for (const RenderedDot& dot : view.dots) {
    const Eigen::Vector2i at = dot.pixel.array().round().cast<int>();
    EXPECT_NEAR(view.on.at(at.x(), at.y()) - view.off.at(at.x(), at.y()), dot.peak_grey, 1.0);
    EXPECT_NEAR(view.off.at(at.x(), at.y()), dot.under_grey, 0.51);
  }
}

TEST(Render, SameSeedSameBitsOnOneThreadAndTwo) {
  SimulatedRig rig = spot_rig(170);
  rig.emitter->speckle_contrast = 0.2;
  const ViewRenderer renderer(rig);
  const Rigid3 pose = pose_at({0.06, 0.01, 0.4}, {10, 0, 0});
  const auto render = [&](std::uint64_t seed, std::uint64_t stream) {
    return renderer.render(0, pose, {.seed = seed, .stream = stream});
  };
  const RenderedView alone = render(7, 1);
  RenderedView beside[2];
  {
    std::jthread other([&] { beside[1] = render(7, 1); });
    beside[0] = render(7, 1);
  }
  for (const RenderedView& view : beside) {
    EXPECT_EQ(view.off.values, alone.off.values);
    EXPECT_EQ(view.on.values, alone.on.values);
  }
  EXPECT_NE(render(8, 1).off.values, alone.off.values);
  EXPECT_NE(render(7, 2).on.values, alone.on.values);
}

// Variance against mean, of paper, ink and background, by the difference of two images; 3 % is three standard
// deviations of a variance out of 20,000 pixels.
TEST(Render, NoiseIsShotAndReadNoise) {
  for (const int bits : {8, 10, 12}) {
    SimulatedRig rig = board_rig(small_camera("pinhole", 100));
    rig.cameras[0].sensor.bits = bits;
    rig.cameras[0].sensor.vignetting = 0;
    const ViewRenderer renderer(rig);
    const Rigid3 pose = pose_at({0, 0, 0.2}, {0, 0, 0});
    const GreyImage mean = renderer.render(0, pose, {.noise = false}).off;
    const GreyImage first = renderer.render(0, pose, {.seed = 1}).off,
                    second = renderer.render(0, pose, {.seed = 2}).off;
    double ratio = 0, offset = 0;
    for (std::size_t i = 0; i < mean.values.size(); ++i) {
      const double sigma = grey_sigma(rig.cameras[0].sensor, mean.values[i]);
      const double difference = first.values[i] - second.values[i];
      ratio += difference * difference / (2 * sigma * sigma) / static_cast<double>(mean.values.size());
      offset += (first.values[i] - mean.values[i]) / sigma / static_cast<double>(mean.values.size());
    }
    EXPECT_NEAR(ratio, 1.0, 0.03) << bits;
    EXPECT_NEAR(offset, 0.0, bits == 8 ? 0.2 : 0.05) << bits;  // the mean has been rounded, too
  }
}

TEST(Render, MuchLightSaturatesAtTheLargestValueAndNoneIsTheBlackLevel) {
  for (const int bits : {8, 10, 12}) {
    SimulatedRig rig = board_rig(small_camera("pinhole", 100));
    SimulatedSensor& sensor = rig.cameras[0].sensor;
    sensor.bits = bits;
    sensor.vignetting = 0;
    const int largest = (1 << bits) - 1;
    const Rigid3 pose = pose_at({0, 0, 0.2}, {0, 0, 0});
    sensor.exposure = 100;
    EXPECT_EQ(std::ranges::min(render_view(rig, 0, pose).off.values), largest);
    rig.light.ambient_W_m2 = 0;
    const GreyImage dark = render_view(rig, 0, pose, {.noise = false}).off;
    EXPECT_EQ(std::ranges::max(dark.values), std::lround(largest * sensor.black_level));
    EXPECT_EQ(std::ranges::min(dark.values), std::ranges::max(dark.values));
  }
}

TEST(Render, VignettingAndExposureScaleTheLight) {
  SimulatedRig rig = board_rig(small_camera("kannala_brandt", 80));
  rig.cameras[0].sensor.vignetting = 5;
  const Rigid3 behind = pose_at({0, 0, -1}, {0, 0, 0});  // the image shows the background only
  const GreyImage once = render_view(rig, 0, behind, {.noise = false}).off;
  rig.cameras[0].sensor.exposure = 2;
  const GreyImage twice = render_view(rig, 0, behind, {.noise = false}).off;
  const double black = 4095 * rig.cameras[0].sensor.black_level;
  for (const Eigen::Vector2i& at : {Eigen::Vector2i(100, 80), Eigen::Vector2i(3, 150), Eigen::Vector2i(199, 0)}) {
    const Eigen::Vector3d ray = *ray_from_pixel(rig.cameras[0].camera, at.cast<double>());
    const double share = std::pow(std::cos(0.5 * std::acos(ray.z())), 5);
    const double expected = 4095 * share * rig.light.background_albedo * rig.light.ambient_W_m2 / 8;
    EXPECT_NEAR(once.at(at.x(), at.y()) - black, expected, 1.0);
    EXPECT_NEAR(twice.at(at.x(), at.y()) - black, 2 * expected, 1.0);
  }
}

TEST(Render, TheSunLightsTheBoardByTheCosine) {
  SimulatedRig rig = board_rig(small_camera("pinhole", 100));
  rig.cameras[0].sensor.vignetting = 0;
  rig.board.print.boxes.clear();
  rig.light.sun_W_m2 = 3;
  const double black = 4095 * rig.cameras[0].sensor.black_level;
  const auto grey_at_middle = [&](const Eigen::Vector3d& sun_direction) {
    rig.light.sun_direction = sun_direction;
    return render_view(rig, 0, pose_at({0, 0, 0.3}, {0, 30, 0}), {.noise = false}).off.at(100, 80);
  };
  const Eigen::Vector3d facing(-0.5, 0, -std::sqrt(0.75)), aside(0, 2, 0), behind = -facing;
  const auto expected = [&](double cosine) {
    return black + 4095 * rig.board.paper_albedo * (rig.light.ambient_W_m2 + 3 * cosine) / 8;
  };
  EXPECT_NEAR(grey_at_middle(facing), expected(1), 1);
  EXPECT_NEAR(grey_at_middle(facing + aside.normalized()), expected(std::numbers::sqrt2 / 2), 1);
  EXPECT_NEAR(grey_at_middle(behind), expected(0), 1);
}

// Speckle leaves the mean and has the stated contrast; shot noise is left out.
TEST(Render, SpeckleHasItsContrast) {
  SimulatedRig rig = spot_rig(170);
  rig.emitter->speckle_contrast = 0.3;
  const ViewRenderer renderer(rig);
  const Rigid3 pose = pose_at({0.06, 0.01, 0.4}, {0, 0, 0});
  double sum = 0, squares = 0;
  int count = 0;
  for (std::uint64_t stream = 0; stream < 60; ++stream) {
    const RenderedView view = renderer.render(0, pose, {.stream = stream, .noise = false});
    for (const RenderedDot& dot : view.dots) {
      const Eigen::Vector2i at = dot.pixel.array().round().cast<int>();
      const double factor = (view.on.at(at.x(), at.y()) - view.off.at(at.x(), at.y())) / dot.peak_grey;
      sum += factor;
      squares += factor * factor;
      ++count;
    }
  }
  const double mean = sum / count;
  EXPECT_NEAR(mean, 1.0, 0.05);  // 540 pixels: standard deviation 0.013
  EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 0.3, 0.04);
}

// A beam on the edge of the board lights both sides of it: what misses the board arrives behind it.
TEST(Render, ABeamOnTheEdgeIsSplit) {
  SimulatedRig rig = spot_rig(170);
  rig.cameras[0].sensor.vignetting = 0;
  const ViewRenderer renderer(rig);
  const Line3 middle = renderer.beams()[4].line;
  const double x = middle.at(0.4 / middle.direction.z()).x();
  Rigid3 pose = pose_at({0.06, 0.01, 0.4}, {0, 0, 0});
  const double whole = spot_sum(renderer.render(0, pose, kExact), renderer.render(0, pose, kExact).dots[4].pixel);
  pose.translation.x() = x - rig.board.print.sheet.high.x();  // its right edge is where the beam is
  const RenderedView split = renderer.render(0, pose, kExact);
  const auto on_board = pixel_from_ray(
      rig.cameras[0].camera,
      pose * Eigen::Vector3d(rig.board.print.sheet.high.x(), middle.at(0.4).y() - pose.translation.y(), 0));
  EXPECT_NEAR(spot_sum(split, *on_board) / whole, 0.5, 0.02);
}

}  // namespace
}  // namespace raybundle::testing
