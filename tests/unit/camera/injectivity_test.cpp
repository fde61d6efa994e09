// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/camera/injectivity.hpp"

#include <gtest/gtest.h>

#include "law_support.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

TEST(Injectivity, PinholeCoversItsImage) {
  const Camera camera = start_camera(*model_named("pinhole"), {641, 481}, 320.0);
  const InjectivityReport report = check_injectivity(camera);
  EXPECT_TRUE(report.one_to_one());
  EXPECT_EQ(report.covered_fraction, 1.0);
  EXPECT_NEAR(report.nearest_border_angle_rad, std::atan(240.0 / 320.0), 1e-12);
  EXPECT_NEAR(report.farthest_border_angle_rad, std::atan(400.0 / 320.0), 1e-12);
}

TEST(Injectivity, FoldInsideTheImageIsFoundAtItsRadius) {
  Camera camera = start_camera(*model_named("brown_conrady"), {641, 481}, 320.0);
  camera.parameters[4] = -1.0 / 3.0;  // r (1 - r²/3): top at r = 1, value 2/3, so 213.3 px from the centre
  const InjectivityReport report = check_injectivity(camera, 201);
  EXPECT_FALSE(report.one_to_one());
  EXPECT_NEAR(report.first_offender_radius_px, 320.0 * 2.0 / 3.0, 3.5);  // the grid's step
  EXPECT_NEAR(report.max_angle_rad, M_PI_4, 1e-9);
  EXPECT_NEAR(report.covered_fraction, M_PI * 213.33 * 213.33 / (641 * 481), 0.02);
}

TEST(Injectivity, EquidistantFisheyeEndsStraightBehind) {
  const Camera camera = start_camera(*model_named("kannala_brandt"), {961, 601}, 150.0);
  const InjectivityReport report = check_injectivity(camera);
  EXPECT_FALSE(report.one_to_one());
  EXPECT_NEAR(report.first_offender_radius_px, M_PI * 150.0, 16.0);  // the grid's step
  EXPECT_NEAR(report.nearest_border_angle_rad, 2.0, 1e-9);
}

TEST(Injectivity, EmptyImageAndWrongParameterCountAreRefused) {
  Camera camera = start_camera(*model_named("pinhole"), {0, 0}, 320.0);
  EXPECT_THROW(check_injectivity(camera), Error);
  camera = start_camera(*model_named("kannala_brandt"), {640, 480}, 320.0);
  camera.parameters.conservativeResize(4);
  EXPECT_THROW(check_injectivity(camera), Error);
}

}  // namespace
}  // namespace raybundle
