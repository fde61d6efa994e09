// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/dot_finder.hpp"

#include <gtest/gtest.h>

#include "spot_image.hpp"
#include "worlds.hpp"

namespace raybundle {
namespace {

using testing::LightOptions;
using testing::SceneDot;
using testing::SpotImage;

struct Found {
  int there = 0, found = 0, false_dots = 0;
  double rms_px = 0.0;       // each coordinate
  double chi_squared = 0.0;  // of a coordinate, mean
};

// Dots of cabins, painted and found again.
Found find_dots(const LightOptions& light, bool difference, int scenes) {
  const testing::SensorWorld world = testing::sensor_world({11, 11}, 12.0);
  const ImageSize size = world.camera.camera.size;
  DotFinder finder(size, 400, {.read_noise = light.read_noise, .grey_per_electron = light.grey_per_electron});
  Found sum;
  double squares = 0.0, chi = 0.0;
  for (int s = 0; s < scenes; ++s) {
    Random random(8, s);
    const auto dots = dots_in(testing::CabinScene(s), world.camera, world.beams, world.rig.emitter->grid,
                              {.sigma_px = 0.0, .missed = 0.0, .spurious = 0.0}, random);
    const SpotImage on(size, dots, true, light, random), off(size, dots, false, light, random);
    const auto found = finder.find(on.view(), difference ? off.view() : GreyView{});
    std::vector<char> used(found.size());
    for (const SceneDot& dot : dots) {
      const Eigen::Vector2d& at = dot.dot.pixel;
      if (at.x() < 10 || at.y() < 10 || at.x() > size.width - 11 || at.y() > size.height - 11) continue;
      ++sum.there;
      for (std::size_t i = 0; i < found.size(); ++i) {
        const Eigen::Vector2d error = found[i].pixel - at;
        if (error.norm() > 1.0) continue;
        used[i] = 1;
        ++sum.found;
        squares += error.squaredNorm() / 2.0;
        chi += error.dot(found[i].covariance_px2.inverse() * error) / 2.0;
        break;
      }
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Eigen::Vector2d& at = found[i].pixel;
      const bool rim = at.x() < 11 || at.y() < 11 || at.x() > size.width - 12 || at.y() > size.height - 12;
      sum.false_dots += !used[i] && !rim;
    }
  }
  sum.rms_px = std::sqrt(squares / sum.found);
  sum.chi_squared = chi / sum.found;
  return sum;
}

TEST(DotFinder, FindsDotsWhereTheyAreAsItsCovarianceSays) {
  const Found found = find_dots({}, false, 5);
  EXPECT_GE(found.found, 0.98 * found.there);  // some lie beside each other
  EXPECT_LE(found.false_dots, 2);
  EXPECT_LE(found.rms_px, 0.06);
  EXPECT_GT(found.chi_squared, 0.5);
  EXPECT_LT(found.chi_squared, 2.0);
}

TEST(DotFinder, IsNotMisledBySunPatchesTextureAndDarkness) {
  const Found sun = find_dots({.sun = 120.0}, false, 3);
  EXPECT_GE(sun.found, 0.9 * sun.there);  // the dots in the sun are the weaker ones
  EXPECT_LE(sun.false_dots, 2);           // along the rim of the patch
  const Found texture = find_dots({.texture = 20.0}, false, 3);
  EXPECT_GE(texture.found, 0.95 * texture.there);
  EXPECT_LE(texture.false_dots, 0.03 * texture.there);
  const Found dark = find_dots({.ambient = 3.0, .spot_peak = 20.0}, false, 3);
  EXPECT_GE(dark.found, 0.95 * dark.there);
  EXPECT_LE(dark.false_dots, 0.03 * dark.there);
}

TEST(DotFinder, UsesAnImageWithoutTheLaser) {
  const Found found = find_dots({.sun = 120.0, .texture = 20.0}, true, 3);
  EXPECT_GE(found.found, 0.95 * found.there);
  EXPECT_LE(found.false_dots, 2);
  EXPECT_LE(found.rms_px, 0.12);
}

// A reflex beside a dot is left out of its surroundings, on one side: their plane must not tilt for that.
TEST(DotFinder, IsNotPulledByASpeckBesideADot) {
  const ImageSize size{64, 48};
  DotFinder finder(size, 50);
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(32.0, 24.0), Eigen::Vector2d(32.4, 24.3), Eigen::Vector2d(31.7, 23.9)}) {
    std::vector<std::uint8_t> pixels;
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const double speck = u == 36 && std::abs(v - 24) <= 1 ? 60.0 : 0.0;
        const double dot = 90.0 * std::exp(-(Eigen::Vector2d(u, v) - at).squaredNorm() / (2.0 * 0.8 * 0.8));
        pixels.push_back(static_cast<std::uint8_t>(std::lround(80.0 + dot + speck)));
      }
    }
    const auto found = finder.find({pixels.data(), size.width, size.height, size.width});
    ASSERT_FALSE(found.empty());
    const auto off = [&](const Dot& dot) { return (dot.pixel - at).norm(); };
    EXPECT_LT(off(*std::ranges::min_element(found, {}, off)), 0.03);  // whole grey values; 0.15 and more by a tilt
  }
}

TEST(DotFinder, FindsNothingInEmptyFlatAndDefectImages) {
  const ImageSize size{64, 48};
  DotFinder finder(size, 50);
  std::vector<std::uint8_t> pixels(64 * 48, 100);
  const GreyView image{pixels.data(), 64, 48, 64};
  EXPECT_TRUE(finder.find(image).empty());
  pixels[24 * 64 + 30] = 255;  // a hot pixel
  EXPECT_TRUE(finder.find(image).empty());
  pixels[24 * 64 + 30] = 100;
  for (int v = 0; v < 48; ++v) pixels[v * 64 + 31] = pixels[v * 64 + 32] = 200;  // a ridge
  EXPECT_TRUE(finder.find(image).empty());
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) pixels[v * 64 + u] = u + v > 50 ? 220 : 60;  // an edge
  }
  EXPECT_TRUE(finder.find(image).empty());
}

TEST(DotFinder, TakesImagesOfAnySize) {
  for (const ImageSize size : {ImageSize{1, 1}, {2, 9}, {7, 7}, {13, 200}, {33, 31}}) {
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(size.width) * size.height, 7);
    DotFinder finder(size, 10);
    EXPECT_TRUE(finder.find({pixels.data(), size.width, size.height, size.width}).empty());
  }
}

}  // namespace
}  // namespace raybundle
