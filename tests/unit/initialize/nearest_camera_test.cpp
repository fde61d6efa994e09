// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/nearest_camera.hpp"

#include <gtest/gtest.h>

namespace raybundle {
namespace {

constexpr ImageSize kSize{1280, 960};

Camera fisheye() {
  Camera camera = start_camera(*model_named("kannala_brandt"), kSize, 420.0);
  camera.parameters.tail<4>() << -0.02, 0.005, -0.003, 0.0004;
  camera.parameters.segment<2>(2) << 650.3, 470.9;
  return camera;
}

// A model that holds another has the same image, whatever the coefficients are called.
TEST(NearestCamera, IsTheSameOfAModelThatHoldsTheOther) {
  Camera brown = start_camera(*model_named("brown_conrady"), kSize, 900.0);
  brown.parameters.tail<5>() << -0.2, 0.08, 0.001, -0.0005, -0.01;
  for (const char* wider : {"rational", "thin_prism"}) {
    const std::vector<PixelRay> rays = rays_over_image(brown);
    const Camera found = nearest_camera(rays, brown, *model_named(wider));
    const CameraDifference difference = difference_over(rays, found);
    EXPECT_LT(difference.largest_px, 1e-3) << wider;  // k1 to k6 hardly tell: a valley, not a point
    EXPECT_EQ(difference.lost_share, 0.0);
  }
  Camera sphere = start_camera(*model_named("extended_unified"), kSize, 400.0);
  sphere.parameters.tail<2>() << 0.6, 1.0;
  const std::vector<PixelRay> rays = rays_over_image(sphere);
  const Camera found = nearest_camera(rays, sphere, *model_named("unified"), {5, 6, 7, 8});
  EXPECT_LT(difference_over(rays, found).largest_px, 1e-9);
  EXPECT_NEAR(found.parameters[4], 0.6 / (1.0 - 0.6), 1e-9);  // xi
}

TEST(NearestCamera, KeepsZeroWhatTheOtherFormatLacks) {
  const std::vector<PixelRay> rays = rays_over_image(fisheye(), 0.6);
  const Camera found = nearest_camera(rays, fisheye(), *model_named("brown_conrady"), {8});
  EXPECT_EQ(found.parameters[8], 0.0);
  const Camera free = nearest_camera(rays, fisheye(), *model_named("brown_conrady"));
  EXPECT_LT(difference_over(rays, free).rms_px, difference_over(rays, found).rms_px);
}

TEST(NearestCamera, DoesNotTurnTheCamera) {
  const Camera camera = fisheye();
  const std::vector<PixelRay> rays = rays_over_image(camera);
  const Camera found = nearest_camera(rays, camera, *model_named("double_sphere"));
  EXPECT_NEAR(found.cx(), camera.cx(), 0.05);
  EXPECT_NEAR(found.cy(), camera.cy(), 0.05);
  EXPECT_LT(difference_over(rays, found).rms_px, 1.0);
}

TEST(CameraDifference, TellsWhatTheOtherDoesNotSee) {
  const Camera wide =
      start_camera(*model_named("kannala_brandt"), kSize, 300.0);  // 90 degrees are reached within the image
  const Camera pinhole = start_camera(*model_named("pinhole"), kSize, 300.0);
  const std::vector<PixelRay> all = rays_over_image(wide);
  const CameraDifference difference = difference_over(all, pinhole);
  EXPECT_GT(difference.lost_share, 0.1);
  EXPECT_LT(difference.lost_share, 0.6);
  const std::vector<PixelRay> inner = rays_over_image(wide, 0.5);
  EXPECT_LT(inner.size(), all.size());
  EXPECT_EQ(difference_over(inner, pinhole).lost_share, 0.0);
  EXPECT_LT(difference_over(inner, wide).largest_px, 1e-9);
}

}  // namespace
}  // namespace raybundle
