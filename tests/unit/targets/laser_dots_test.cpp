// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/laser_dots.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

#include "raybundle/geometry/error.hpp"
#include "spot_render.hpp"

namespace raybundle {
namespace {

using testing::render_spots;
using testing::SpotFrame;
using testing::SpotScene;
using testing::TrueSpot;

// Distance to the nearest true spot.
double distance_of(const Dot& dot, const SpotFrame& frame) {
  double least = 1e9;
  for (const TrueSpot& spot : frame.spots) least = std::min(least, (dot.pixel - spot.pixel).norm());
  return least;
}

const Dot* dot_near(const FoundDots& found, const Eigen::Vector2d& pixel) {
  for (const Dot& dot : found.dots) {
    if ((dot.pixel - pixel).norm() < 1.0) return &dot;
  }
  return nullptr;
}

SpotScene small_scene() {
  SpotScene scene;
  scene.width = 320;
  scene.height = 240;
  scene.rows = 7;
  scene.columns = 9;
  scene.snr = 15;
  return scene;
}

// A spot drawn into a noisy frame.
void add_spot(cv::Mat& image, const Eigen::Vector2d& pixel, double amplitude, double sigma_px) {
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double squares = (Eigen::Vector2d(x, y) - pixel).squaredNorm();
      const double value = amplitude * std::exp(-0.5 * squares / (sigma_px * sigma_px));
      auto& grey = image.at<std::uint8_t>(y, x);
      grey = cv::saturate_cast<std::uint8_t>(grey + value);
    }
  }
}

TEST(LaserDots, OverPrintWithLaserOffImageAllAreFoundWhereTheyAre) {
  const SpotFrame frame = render_spots(small_scene());
  const FoundDots found = find_dots(frame.on, &frame.off);
  int even = 0, seen = 0;
  double normalised = 0;
  for (const TrueSpot& spot : frame.spots) {
    if (spot.edge_sigmas < 3) continue;  // light on print of both kinds may be too faint
    ++even;
    const Dot* dot = dot_near(found, spot.pixel);
    if (dot == nullptr) continue;
    ++seen;
    const Eigen::Vector2d error = dot->pixel - spot.pixel;
    normalised += error.dot(dot->covariance_px2.inverse() * error) / 2;
    EXPECT_LT(error.norm(), 5 * std::sqrt(spot.bound_px2.trace()));
    EXPECT_EQ(dot->beam, kUnlabelled);
    EXPECT_GT(dot->brightness, 0);
  }
  EXPECT_GE(seen, even - 1);
  EXPECT_NEAR(normalised / seen, 1, 0.5);  // 2·40 degrees of freedom: sigma 0.16
  // Noise alone looks like a faint spot about once in an image.
  EXPECT_LE(std::ranges::count_if(found.dots, [&](const Dot& dot) { return distance_of(dot, frame) > 1.5; }), 2);
  EXPECT_NEAR(found.spot_sigma_px, frame.sigma_px, 0.15);
}

TEST(LaserDots, CornersOfTheBoardAreNeverDots) {
  SpotScene scene = small_scene();
  scene.rows = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    scene.seed = seed;
    const SpotFrame frame = render_spots(scene);
    EXPECT_LE(find_dots(frame.on).dots.size(), 1U) << "seed " << seed;
    EXPECT_LE(find_dots(frame.on, &frame.off).dots.size(), 1U) << "seed " << seed;
  }
}

TEST(LaserDots, TwelveBitsAndAnotherAmbientLightChangeNothing) {
  SpotScene scene = small_scene();
  scene.bits = 12;
  scene.off_scale = 0.8;
  const SpotFrame frame = render_spots(scene);
  ASSERT_EQ(frame.on.depth(), CV_16U);
  const FoundDots found = find_dots(frame.on, &frame.off);
  int even = 0, seen = 0;
  for (const TrueSpot& spot : frame.spots) {
    if (spot.edge_sigmas < 3) continue;
    ++even;
    seen += dot_near(found, spot.pixel) != nullptr;
  }
  EXPECT_GE(seen, even - 1);
}

TEST(LaserDots, SaturatedClippedAndDoubleSpotsAreGated) {
  SpotScene scene = small_scene();
  scene.rows = 0;
  scene.square_px = 0;
  SpotFrame frame = render_spots(scene);
  for (int i = 0; i < 8; ++i) add_spot(frame.on, {40.3 + 30 * i, 60.2}, 60, 1.4);
  add_spot(frame.on, {50, 120}, 400, 1.4);    // saturated
  add_spot(frame.on, {100.4, 0.6}, 60, 1.4);  // clipped
  add_spot(frame.on, {150, 120}, 60, 1.4);    // two that overlap
  add_spot(frame.on, {153.2, 120}, 60, 1.4);
  for (const cv::Mat* off : {static_cast<const cv::Mat*>(nullptr), static_cast<const cv::Mat*>(&frame.off)}) {
    const FoundDots found = find_dots(frame.on, off);
    EXPECT_EQ(found.saturated, 1);
    EXPECT_GE(found.clipped, 1);
    for (int i = 0; i < 8; ++i) EXPECT_NE(dot_near(found, {40.3 + 30 * i, 60.2}), nullptr);
    EXPECT_LE(found.dots.size(), 10U);  // noise alone looks like a faint spot about once in an image
    EXPECT_EQ(dot_near(found, {50, 120}), nullptr);
    EXPECT_EQ(dot_near(found, {100.4, 0.6}), nullptr);
    EXPECT_EQ(dot_near(found, {151.6, 120}), nullptr);
    EXPECT_EQ(dot_near(found, {150, 120}), nullptr);
  }
}

TEST(LaserDots, OnlyInTheRegion) {
  const SpotFrame frame = render_spots(small_scene());
  DotOptions options;
  options.region = {{100, 60}, {220, 60}, {220, 180}, {100, 180}};
  const FoundDots found = find_dots(frame.on, &frame.off, options);
  ASSERT_GT(found.dots.size(), 5U);
  for (const Dot& dot : found.dots) {
    EXPECT_TRUE(dot.pixel.x() > 98 && dot.pixel.x() < 222 && dot.pixel.y() > 58 && dot.pixel.y() < 182);
  }
}

TEST(LaserDots, SameBitsEveryTime) {
  const SpotFrame frame = render_spots(small_scene());
  const FoundDots first = find_dots(frame.on), second = find_dots(frame.on);
  ASSERT_EQ(first.dots.size(), second.dots.size());
  for (std::size_t i = 0; i < first.dots.size(); ++i) {
    EXPECT_EQ(first.dots[i].pixel, second.dots[i].pixel);
    EXPECT_EQ(first.dots[i].covariance_px2, second.dots[i].covariance_px2);
  }
}

TEST(LaserDots, NothingToSeeAndWrongImages) {
  EXPECT_TRUE(find_dots(cv::Mat(cv::Mat::zeros(48, 64, CV_8U))).dots.empty());
  EXPECT_TRUE(find_dots(cv::Mat(cv::Mat::zeros(3, 3, CV_8U))).dots.empty());
  EXPECT_THROW(find_dots(cv::Mat(48, 64, CV_8UC3)), Error);
  EXPECT_THROW(find_dots(cv::Mat()), Error);
  const cv::Mat on = cv::Mat::zeros(48, 64, CV_8U), off = cv::Mat::zeros(48, 60, CV_8U);
  EXPECT_THROW(find_dots(on, &off), Error);
}

}  // namespace
}  // namespace raybundle
