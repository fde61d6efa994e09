// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "self_test.hpp"

#include "calibration_format.hpp"

namespace raybundle {

std::vector<TestedPoint> self_tests_of(const RigCamera& camera) {
  std::vector<TestedPoint> tests;
  for (const double v : {0.1, 0.5, 0.9}) {
    for (const double u : {0.1, 0.5, 0.9}) {
      const Eigen::Vector2d grid(u * (camera.camera.size.width - 1), v * (camera.camera.size.height - 1));
      const auto ray = ray_from_pixel(camera.camera, grid);
      if (!ray || !ray->allFinite()) continue;
      const Eigen::Vector3d x_in_rig = camera.camera_from_rig.inverse() * *ray;
      const auto pixel = pixel_from_ray(camera.camera, camera.camera_from_rig * x_in_rig);
      const auto again = pixel_from_ray(camera.camera, *ray);
      // A number that rounding alone moves so far tests nothing.
      if (!pixel || !again || !((*pixel - *again).norm() < 0.1 * kSelfTestTolerance_px)) continue;
      tests.push_back({x_in_rig, *ray, *pixel});
    }
  }
  return tests;
}

}  // namespace raybundle
