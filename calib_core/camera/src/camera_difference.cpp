// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/camera/camera_difference.hpp"

#include <cmath>

namespace raybundle {

std::vector<PixelRay> rays_over_image(const Camera& camera, double max_angle_rad, int samples_per_side) {
  std::vector<PixelRay> rays;
  const double intervals = samples_per_side - 1;
  for (int row = 0; row < samples_per_side; ++row) {
    for (int column = 0; column < samples_per_side; ++column) {
      const Eigen::Vector2d pixel(column / intervals * (camera.size.width - 1),
                                  row / intervals * (camera.size.height - 1));
      const auto ray = ray_from_pixel(camera, pixel);
      if (ray && std::atan2(ray->head<2>().norm(), ray->z()) <= max_angle_rad) rays.push_back({pixel, *ray});
    }
  }
  return rays;
}

CameraDifference difference_over(const std::vector<PixelRay>& rays, const Camera& other) {
  CameraDifference difference;
  double squares = 0.0;
  std::size_t lost = 0;
  for (const auto& [pixel, ray] : rays) {
    const auto found = pixel_from_ray(other, ray);
    if (!found) {
      ++lost;
      continue;
    }
    const double distance = (*found - pixel).norm();
    squares += distance * distance;
    if (distance < difference.largest_px) continue;
    difference.largest_px = distance;
    difference.largest_at = pixel;
  }
  if (rays.size() > lost) difference.rms_px = std::sqrt(squares / static_cast<double>(rays.size() - lost));
  if (!rays.empty()) difference.lost_share = static_cast<double>(lost) / static_cast<double>(rays.size());
  return difference;
}

}  // namespace raybundle
