// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/camera_rays.hpp"

#include <cmath>
#include <limits>

namespace raybundle {

CameraRays::CameraRays(const SimulatedCamera& camera, int margin_px)
    : margin_(margin_px), columns_(camera.camera.size.width + 2 * margin_px + 1) {
  const ImageSize size = camera.camera.size;
  const double largest_rad = max_angle_rad(camera.camera);
  for (int y = -margin_; y <= size.height + margin_; ++y) {
    for (int x = -margin_; x <= size.width + margin_; ++x) {
      const auto ray = ray_from_pixel(camera.camera, {x - 0.5, y - 0.5});
      const bool lands = ray && std::atan2(ray->head<2>().norm(), ray->z()) <= largest_rad;
      corners_.push_back(lands ? *ray : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    }
  }
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double half_angle_cosine =
          lit(x, y) ? std::sqrt(0.5 + 0.5 * std::min(1.0, at(x, y, 0.5, 0.5).normalized().z())) : 0.0;
      vignetting_.push_back(static_cast<float>(lit(x, y) ? std::pow(half_angle_cosine, camera.sensor.vignetting) : 0));
    }
  }
}

bool CameraRays::lit(int x, int y) const {
  const int i = corner(x, y);
  return !std::isnan(corners_[i].x() + corners_[i + 1].x() + corners_[i + columns_].x() +
                     corners_[i + columns_ + 1].x());
}

Eigen::Vector3d CameraRays::at(int x, int y, double u, double v) const {
  const Eigen::Vector3d* c = &corners_[corner(x, y)];
  return (1 - v) * ((1 - u) * c[0] + u * c[1]) + v * ((1 - u) * c[columns_] + u * c[columns_ + 1]);
}

}  // namespace raybundle
