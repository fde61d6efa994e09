// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "raybundle/targets/laser_dots.hpp"
#include "real_images.hpp"

namespace raybundle {
namespace {

using testing::grey_image;
using testing::real_images;

// A projector's dots, thousands of them and some in touching pairs, on a board that fills most of the image: both
// cameras must see about as many. How many there are in truth nobody has counted.
TEST(LaserDotsReal, InfraredDotsOfAStereoPair) {
  const auto files = real_images("ir_dots/hjs_images_real");
  RAYBUNDLE_NEEDS_IMAGES(files, "ir_dots/hjs_images_real");
  ASSERT_EQ(files.size(), 2U);
  for (const auto& file : files) {
    const FoundDots found = find_dots(grey_image(file));
    EXPECT_GT(found.dots.size(), 3500U);
    EXPECT_LT(found.dots.size(), 6500U);
    EXPECT_NEAR(found.spot_sigma_px, 1.4, 0.3);
  }
}

// A laser line is no dot. What is left of ten thousand peaks are marks of JPEG, which noise estimates do not know.
TEST(LaserDotsReal, ALineIsNoDot) {
  const auto on = real_images("linelight_zhao/light_picture", "light0.");
  const auto off = real_images("linelight_zhao/calib_picture", "calib0.");
  RAYBUNDLE_NEEDS_IMAGES(on, "linelight_zhao/light_picture");
  ASSERT_EQ(off.size(), 1U);
  const cv::Mat dark = grey_image(off[0]);
  EXPECT_LT(find_dots(grey_image(on[0]), &dark).dots.size(), 200U);
}

}  // namespace
}  // namespace raybundle
