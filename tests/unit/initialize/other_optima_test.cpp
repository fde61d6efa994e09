// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/other_optima.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "synthetic_world.hpp"

namespace raybundle {
namespace {

std::vector<Eigen::Vector3d> rays_up_to(double angle_rad) {
  std::vector<Eigen::Vector3d> rays;
  for (double angle = 0.05; angle < angle_rad; angle += 0.05) {
    for (double azimuth = 0.1; azimuth < 6.2; azimuth += 0.4) {
      rays.emplace_back(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle));
    }
  }
  return rays;
}

Camera camera_of(std::string_view model, std::vector<double> parameters) {
  Camera camera{*model_named(model), {640, 480}, {}};
  camera.parameters =
      Eigen::Map<const Eigen::VectorXd>(parameters.data(), static_cast<Eigen::Index>(parameters.size()));
  return camera;
}

// Up to 70 degrees this lens projects within half a pixel as another one does whose first sphere is shifted the other
// way.
TEST(TwinCameras, ADoubleSphereHasOneOfTheOtherSign) {
  const Camera camera = camera_of("double_sphere", {669.1, 645.7, 321.8, 242.1, 0.82, 2.153});
  const std::vector<Camera> twins = twin_cameras(camera, rays_up_to(1.2), 0.5);
  EXPECT_THAT(twins, ::testing::Contains(::testing::Truly([](const Camera& twin) { return twin.parameters[4] < 0; })));
}

TEST(TwinCameras, KannalaBrandtHasNone) {
  const Camera camera = camera_of("kannala_brandt", {250, 250, 320, 240, -0.02, 0.005, -0.003, 0.0004});
  EXPECT_THAT(twin_cameras(camera, rays_up_to(1.4), 0.5), ::testing::IsEmpty());
}

// Up to 50 degrees, from a camera whose denominator ends at 30.
TEST(FittedAnew, LeavesThePoleBehindAndHoldsZeros) {
  const Camera truth = camera_of("rational", {600, 600, 320, 240, 0.3, 0, 0, 0, 0, 0.5, 0, 0});
  Camera with_pole = truth;
  with_pole.parameters[9] = -3.0;
  const std::vector<Eigen::Vector3d> rays = rays_up_to(0.87);
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector3d& ray : rays) pixels.push_back(*pixel_from_ray(truth, ray));
  const Camera fitted = fitted_anew(with_pole, rays, pixels, {10, 11});
  EXPECT_EQ(fitted.parameters.tail<2>(), Eigen::Vector2d::Zero());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto pixel = pixel_from_ray(fitted, rays[i]);
    ASSERT_TRUE(pixel) << i;
    EXPECT_LT((*pixel - pixels[i]).norm(), 3.0) << i;  // what a start has to be within
  }
}

// A board of two rows: its length tells how it is tilted along, but hardly its width how it is turned about it.
TEST(MirroredPose, OfANarrowBoardSettles) {
  const Camera camera = camera_of("pinhole", {600, 600, 320, 240});
  const Target board = testing::grid_target("board", 10, 2, 0.03);
  const auto turned_by = [](double turn_rad) {
    Rigid3 pose;
    pose.rotation = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()) *
                    Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitX()));
    pose.translation << -0.1, -0.015, 0.6;
    return pose;
  };
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (const TargetPoint& point : board.points) {
    points.push_back(point.x_in_target);
    pixels.push_back(*pixel_from_ray(camera, turned_by(0.5) * point.x_in_target));
  }
  const auto other = find_mirrored_pose(camera, points, pixels, turned_by(-0.5));
  ASSERT_TRUE(other);
  EXPECT_LT(other->squares_ratio, 1e-6);
  EXPECT_LT(angle_between(other->camera_from_target, turned_by(0.5)), 1e-6);  // the pixels are exact
}

TEST(MirroredPose, TurnsABoardThatIsHeldTheWrongWayAndLeavesARightOne) {
  const Camera camera = camera_of("pinhole", {600, 600, 320, 240});
  const Target board = testing::grid_target("board", 7, 5, 0.03);
  const auto tilted = [](double tilt_rad) {
    Rigid3 pose;
    pose.rotation = Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX());
    pose.translation << -0.09, -0.06, 3.0;
    return pose;
  };
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (const TargetPoint& point : board.points) {
    points.push_back(point.x_in_target);
    pixels.push_back(*pixel_from_ray(camera, tilted(0.5) * point.x_in_target) +
                     Eigen::Vector2d(0.01, 0) * (point.id % 3));
  }
  const auto turned = find_mirrored_pose(camera, points, pixels, tilted(-0.5));
  ASSERT_TRUE(turned);
  EXPECT_LT(turned->squares_ratio, 1.0);
  EXPECT_LT(angle_between(turned->camera_from_target, tilted(0.5)), 0.05);  // 0.01 px of a board that fills 40 px
  const auto turned_back = find_mirrored_pose(camera, points, pixels, turned->camera_from_target);
  EXPECT_TRUE(!turned_back || turned_back->squares_ratio > 1.0);
}

}  // namespace
}  // namespace raybundle
