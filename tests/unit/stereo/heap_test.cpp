// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// What ships on a device takes its memory at the start.
#include <gtest/gtest.h>

#include <random>

#include "heap_calls.hpp"
#include "raybundle/stereo/dot_fusion.hpp"
#include "raybundle/stereo/exposure_control.hpp"
#include "raybundle/stereo/ray_grid.hpp"
#include "raybundle/stereo/stereo.hpp"

namespace raybundle {
namespace {

TEST(Stereo, TakesNoMemoryAfterItsStart) {
  constexpr ImageSize kSize{160, 120};
  Calibration calibration;
  calibration.cameras = {{"left", start_camera({0}, kSize, 150.0), {}}, {"right", start_camera({0}, kSize, 150.0), {}}};
  calibration.cameras[1].camera_from_rig.translation = {-0.1, 0.0, 0.0};
  StereoMatcher matcher(calibration, "left", "right");
  const ImageSize rectified = matcher.rectification().camera.size;
  DotFusion fusion(rectified);
  RayGrid grid(matcher.rectification().camera, {.rays_per_rad = 50, .field_x_rad = 2, .field_y_rad = 2});
  ExposureControl exposure(kSize, {.least_shutter_s = 1e-4, .most_shutter_s = 1e-2});

  std::mt19937 random(1);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(kSize.width) * (kSize.height + 1));
  for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(random() % 256);
  const GreyView left{pixels.data(), kSize.width, kSize.height, kSize.width};
  const GreyView right{pixels.data() + 10, kSize.width, kSize.height, kSize.width};  // a disparity of ten pixels
  std::vector<AnchorDot> dots;
  for (int v = 5; v < rectified.height; v += 10) {
    for (int u = 5; u < rectified.width; u += 10) dots.push_back({1.0 * u, 1.0 * v, 10.0, 0.1});
  }

  const long before = testing::heap_calls;
  EXPECT_EQ(before > 0, testing::kHeapIsCounted);
  int matched = 0;
  for (int i = 0; i < 3; ++i) {
    const StereoFrame frame = matcher.process(left, right);
    matched += frame.disparity.matched;
    grid.thin(frame.points);
    fusion.fuse(frame.left, frame.disparity, dots);
    exposure.update(left, exposure.next());
  }
  EXPECT_EQ(testing::heap_calls - before, 0);
  EXPECT_GT(matched, 1000);
}

}  // namespace
}  // namespace raybundle
