// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/beam_depth.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "raybundle/uncertainty/held_out_dots.hpp"
#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

constexpr double kDepth_m = 1.0;

// A fisheye in some place on a rig, and a beam that passes it at some 8 cm.
RigCamera camera_of_rig() {
  Camera camera = start_camera(*model_named("kannala_brandt"), {1280, 960}, 380.0);
  camera.parameters.tail<4>() << 0.02, -0.01, 0.002, 0.0;
  return {"one", camera, stereo_options(1).cameras[1].camera_from_rig};
}

Line3 beam_beside() { return {{0.2, 0.03, 0.05}, Eigen::Vector3d(0.1, -0.15, 1.0).normalized()}; }

// Range of the beam at the depth.
double range_at_depth(const RigCamera& camera, const Line3& beam) {
  const Line3 in_camera = camera.camera_from_rig * beam;
  return (kDepth_m - in_camera.point.z()) / in_camera.direction.z();
}

double depth_of(const RigCamera& camera, const Line3& beam, const Eigen::Vector2d& pixel) {
  const auto x_in_rig = point_on_beam(camera, beam, pixel, range_at_depth(camera, beam));
  return x_in_rig ? (camera.camera_from_rig * *x_in_rig).z() : std::nan("");
}

Eigen::Vector2d pixel_at(const RigCamera& camera, const Line3& beam, double range_m) {
  return *pixel_from_ray(camera.camera, camera.camera_from_rig * beam.at(range_m));
}

// What a beam, a lens and its place do together, all of them by what one standard deviation is.
TEST(BeamDepth, FollowsADotThatAChangedCameraSeesOnAChangedBeam) {
  const RigCamera camera = camera_of_rig();
  const Line3 beam = beam_beside();
  const Eigen::Vector2d pixel = pixel_at(camera, beam, range_at_depth(camera, beam));
  const Eigen::Vector4d of_beam(2e-6, -1e-6, 3e-6, 1e-6);
  const Eigen::Vector4d of_camera(2e-3, 1e-6, 1e-6, -2e-6);
  const Covariance parameters{
      {"one.fx", "one.k1", "one.camera_from_rig.rotation_y", "one.camera_from_rig.translation_z"},
      of_camera * of_camera.transpose()};

  RigCamera changed = camera;
  changed.camera.parameters[0] += of_camera[0];
  changed.camera.parameters[4] += of_camera[1];
  Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
  motion[1] = of_camera[2];
  motion[5] = of_camera[3];
  changed.camera_from_rig = perturbed(camera.camera_from_rig, motion);
  const double moved = std::abs(depth_of(changed, perturbed(beam, of_beam), pixel) - kDepth_m);
  EXPECT_GT(moved, 1e-6);  // or nothing has been compared
  const BeamDepth depth =
      beam_depth(camera, parameters, beam, of_beam * of_beam.transpose(), of_beam * of_camera.transpose(), kDepth_m);
  EXPECT_NEAR(depth.sigma_m, moved, 1e-3 * moved);  // the second order, of changes in the fifth digit
}

TEST(BeamDepth, FollowsADotThatIsOffAlongItsEpipolarLine) {
  const RigCamera camera = camera_of_rig();
  const Line3 beam = beam_beside();
  const double range_m = range_at_depth(camera, beam);
  const Eigen::Vector2d pixel = pixel_at(camera, beam, range_m);
  const Eigen::Vector2d along = (pixel_at(camera, beam, range_m + 1e-4) - pixel).normalized();
  constexpr double kOff_px = 1e-3;
  const double moved = std::abs(depth_of(camera, beam, pixel + kOff_px * along) - kDepth_m);
  const BeamDepth depth = beam_depth(camera, {}, beam, Eigen::Matrix4d::Zero(), Eigen::MatrixXd(4, 0), kDepth_m);
  EXPECT_EQ(depth.sigma_m, 0.0);
  EXPECT_NEAR(kOff_px * depth.per_px_m, moved, 1e-3 * moved);  // the second order
}

TEST(BeamDepth, IsNothingWhereTheCameraDoesNotSeeTheBeam) {
  const Line3 aside{{0.0, 50.0, 0.0}, Eigen::Vector3d::UnitZ()};  // below the image
  const BeamDepth depth =
      beam_depth(camera_of_rig(), {}, aside, Eigen::Matrix4d::Identity(), Eigen::MatrixXd(4, 0), kDepth_m);
  EXPECT_TRUE(std::isnan(depth.sigma_m));
}

}  // namespace
}  // namespace raybundle::testing
