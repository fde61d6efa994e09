// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/stereo_depth.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

constexpr double kDepth_m = 1.0;

RigCamera pinhole(const std::string& name, double x_m) {
  Camera camera = start_camera(*model_named("pinhole"), {640, 480}, 400.0);
  return {name, camera, {Eigen::Quaterniond::Identity(), {x_m, 0.0, 0.0}}};
}

// Two parallel pinhole cameras a baseline b apart: z = f b / d, so that a relative change of b changes z by as much, a
// turn of the second camera by w shifts its pixels by f w, and a pixel of disparity moves z by z² / (f b).
TEST(StereoDepth, OfParallelPinholesIsTheTextbooks) {
  const RigCamera left = pinhole("left", 0.0), right = pinhole("right", -0.1);
  const Eigen::Vector2d pixel(left.camera.cx(), left.camera.cy());
  const Covariance baseline{{"right.camera_from_rig.translation_x"}, Eigen::MatrixXd::Constant(1, 1, 1e-6)};
  EXPECT_NEAR(stereo_depth(left, right, baseline, pixel, kDepth_m).sigma_m, kDepth_m * 1e-3 / 0.1, 1e-9);
  const Covariance turn{{"right.camera_from_rig.rotation_y"}, Eigen::MatrixXd::Constant(1, 1, 1e-6)};
  EXPECT_NEAR(stereo_depth(left, right, turn, pixel, kDepth_m).sigma_m, 1e-3 * kDepth_m * kDepth_m / 0.1, 1e-9);
  const Covariance none{{}, Eigen::MatrixXd(0, 0)};
  EXPECT_EQ(stereo_depth(left, right, none, pixel, kDepth_m).sigma_m, 0.0);
  EXPECT_NEAR(stereo_depth(left, right, none, pixel, kDepth_m).per_px_m,
              std::sqrt(2.0) * kDepth_m * kDepth_m / (400.0 * 0.1), 2e-2 * 0.035);
}

// A turn of the first camera by the same amount, or shifted centres of both: what all parameters do together.
TEST(StereoDepth, FollowsATriangulationWithChangedCameras) {
  SyntheticOptions options = stereo_options(3);
  const SyntheticWorld world = synthetic_world(options);
  RigCamera left{"left", world.cameras[0], {}}, right{"right", world.cameras[1], world.camera_from_rig[1]};
  const Eigen::Vector2d pixel(500, 420);
  Covariance one{
      {"left.cx", "left.k1", "right.fy", "right.camera_from_rig.rotation_y", "right.camera_from_rig.translation_z"},
      {}};
  const Eigen::VectorXd change = (Eigen::VectorXd(5) << 1e-3, 1e-6, 2e-3, 1e-6, -2e-6).finished();
  one.matrix = change * change.transpose();

  const Eigen::Vector3d in_left =
      kDepth_m / ray_from_pixel(left.camera, pixel)->z() * *ray_from_pixel(left.camera, pixel);
  const Eigen::Vector2d in_right = *pixel_from_ray(right.camera, right.camera_from_rig * in_left);
  left.camera.parameters[2] += change[0];
  left.camera.parameters[4] += change[1];
  right.camera.parameters[1] += change[2];
  Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
  motion[1] = change[3];
  motion[5] = change[4];
  right.camera_from_rig = perturbed(right.camera_from_rig, motion);
  Eigen::Vector3d x = in_left;  // Gauss-Newton with numeric derivatives
  const auto residual = [&](const Eigen::Vector3d& at) {
    Eigen::Vector4d both;
    both << *pixel_from_ray(left.camera, at) - pixel,
        *pixel_from_ray(right.camera, right.camera_from_rig * at) - in_right;
    return both;
  };
  for (int iteration = 0; iteration < 5; ++iteration) {
    Eigen::Matrix<double, 4, 3> jacobian;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k);
      jacobian.col(k) = (residual(x + step) - residual(x - step)) / 2e-5;
    }
    x -= (jacobian.transpose() * jacobian).inverse() * jacobian.transpose() * residual(x);
  }
  const RigCamera before_left{"left", world.cameras[0], {}},
      before_right{"right", world.cameras[1], world.camera_from_rig[1]};
  const double moved = std::abs(x.z() - kDepth_m);
  EXPECT_NEAR(stereo_depth(before_left, before_right, one, pixel, kDepth_m).sigma_m, moved, 1e-3 * moved);
}

TEST(StereoDepth, IsNothingWhereTheSecondCameraDoesNotSee) {
  const RigCamera left = pinhole("left", 0.0), right = pinhole("right", -5.0);
  const Covariance none{{}, Eigen::MatrixXd(0, 0)};
  EXPECT_TRUE(std::isnan(stereo_depth(left, right, none, {320, 240}, kDepth_m).sigma_m));
}

}  // namespace
}  // namespace raybundle::testing
