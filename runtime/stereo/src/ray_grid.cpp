// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/ray_grid.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

// Angles along and across the baseline.
std::optional<Eigen::Vector2d> angles_of(const RectifiedCamera& camera, int u, int v) {
  const auto ray = camera.ray_from_pixel({u, v});
  if (!ray) return std::nullopt;
  return Eigen::Vector2d(std::asin(ray->x()), std::atan2(ray->y(), ray->z()));
}

// Whole pixels about the middle of the image, so that a grid as dense as the camera takes each pixel for one ray.
Eigen::Vector2d middle_of(const RectifiedCamera& camera) {
  return angles_of(camera, camera.size.width / 2, camera.size.height / 2).value_or(Eigen::Vector2d::Zero());
}

}  // namespace

RayGrid::RayGrid(const RectifiedCamera& camera, const RayGridOptions& options) : width_(camera.size.width) {
  const double denser = camera.focal_px / options.rays_per_rad;
  if (!(denser > 1.0 - options.alike)) {
    throw Error(ErrorKind::kBadInput, "the rectified images have " + std::to_string(std::lround(camera.focal_px)) +
                                          " px for each radian, and at least " +
                                          std::to_string(std::lround((1.0 - options.alike) * options.rays_per_rad)) +
                                          " are needed; take larger images, or rectify them to a larger --width");
  }
  const double per_rad = denser < 1.0 + options.alike ? camera.focal_px : options.rays_per_rad;
  pixels_each_way_ = camera.focal_px / per_rad;
  const Eigen::Vector2d middle = middle_of(camera);
  Eigen::Vector2d least = Eigen::Vector2d::Zero(), most = least;
  const auto inside = [&](const Eigen::Vector2d& angles) {
    return std::abs(angles.x()) <= options.field_x_rad / 2 && std::abs(angles.y()) <= options.field_y_rad / 2;
  };
  const auto cell = [&](const Eigen::Vector2d& angles) -> Eigen::Vector2d {
    return ((angles - middle) * per_rad).array().round();
  };
  const auto for_each_pixel = [&](auto&& use) {
    for (int v = 0; v < camera.size.height; ++v) {
      for (int u = 0; u < camera.size.width; ++u) {
        const auto angles = angles_of(camera, u, v);
        if (angles && inside(*angles)) use(cell(*angles), v * width_ + u);
      }
    }
  };
  for_each_pixel([&](const Eigen::Vector2d& at, int) { least = least.cwiseMin(at), most = most.cwiseMax(at); });
  columns_ = static_cast<int>(most.x() - least.x()) + 1;
  rows_ = static_cast<int>(most.y() - least.y()) + 1;
  const auto ray_of = [&](const Eigen::Vector2d& at) {
    return static_cast<std::size_t>((at.y() - least.y()) * columns_ + (at.x() - least.x()));
  };
  first_.assign(static_cast<std::size_t>(rays()) + 1, 0);
  for_each_pixel([&](const Eigen::Vector2d& at, int) { ++first_[ray_of(at) + 1]; });
  of_ray_.reserve(static_cast<std::size_t>(*std::ranges::max_element(first_)));
  for (std::size_t ray = 1; ray < first_.size(); ++ray) first_[ray] += first_[ray - 1];
  pixels_.resize(static_cast<std::size_t>(first_.back()));
  std::vector<int> next = first_;
  for_each_pixel([&](const Eigen::Vector2d& at, int pixel) { pixels_[next[ray_of(at)]++] = pixel; });
  thinned_.resize(static_cast<std::size_t>(rays()));
}

std::span<const StereoPoint> RayGrid::thin(ImageView<const StereoPoint> points) {
  const auto point_of = [&](int pixel) -> const StereoPoint& { return points.at(pixel % width_, pixel / width_); };
  for (std::size_t ray = 0; ray < thinned_.size(); ++ray) {
    of_ray_.clear();
    for (int i = first_[ray]; i < first_[ray + 1]; ++i) {
      const StereoPoint& p = point_of(pixels_[i]);
      if (p.sigma_m > 0) of_ray_.emplace_back(p.x_m * p.x_m + p.y_m * p.y_m + p.z_m * p.z_m, pixels_[i]);
    }
    thinned_[ray] = {};
    if (of_ray_.empty() || 2 * static_cast<int>(of_ray_.size()) < first_[ray + 1] - first_[ray]) continue;
    const auto median = of_ray_.begin() + std::ssize(of_ray_) / 2;
    std::ranges::nth_element(of_ray_, median);
    thinned_[ray] = point_of(median->second);
  }
  return thinned_;
}

}  // namespace raybundle
