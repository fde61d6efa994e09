// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/rectified_camera.hpp"

#include <cmath>

namespace raybundle {

std::string_view rectified_projection_name(RectifiedProjection projection) {
  return projection == RectifiedProjection::kPinhole ? "pinhole" : "equirectangular";
}

std::optional<RectifiedProjection> rectified_projection_named(std::string_view name) {
  for (const auto projection : {RectifiedProjection::kPinhole, RectifiedProjection::kTransverseEquirectangular}) {
    if (name == rectified_projection_name(projection)) return projection;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> RectifiedCamera::pixel_from_ray(const Eigen::Vector3d& ray) const {
  if (projection == RectifiedProjection::kPinhole) {
    if (!(ray.z() > 0)) return std::nullopt;
    return centre_px + focal_px * (ray.head<2>() / ray.z());
  }
  const double across = std::hypot(ray.y(), ray.z());
  if (!(across > 0)) return std::nullopt;
  return centre_px + focal_px * Eigen::Vector2d(std::atan2(ray.x(), across), std::atan2(ray.y(), ray.z()));
}

std::optional<Eigen::Vector3d> RectifiedCamera::ray_from_pixel(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d plane = (pixel - centre_px) / focal_px;
  if (projection == RectifiedProjection::kPinhole) return Eigen::Vector3d(plane.x(), plane.y(), 1.0).normalized();
  if (std::abs(plane.x()) >= M_PI_2 || std::abs(plane.y()) > M_PI) return std::nullopt;
  const double across = std::cos(plane.x());
  return Eigen::Vector3d(std::sin(plane.x()), across * std::sin(plane.y()), across * std::cos(plane.y()));
}

bool RectifiedCamera::contains(const Eigen::Vector2d& pixel) const { return size.contains(pixel); }

double distance_from_disparity(const RectifiedCamera& camera, double baseline_m, double x_px, double disparity_px) {
  if (camera.projection == RectifiedProjection::kPinhole) return camera.focal_px * baseline_m / disparity_px;
  const double right = (x_px - disparity_px - camera.centre_px.x()) / camera.focal_px;
  return baseline_m * std::cos(right) / std::sin(disparity_px / camera.focal_px);
}

double disparity_from_distance(const RectifiedCamera& camera, double baseline_m, double x_px, double distance_m) {
  if (camera.projection == RectifiedProjection::kPinhole) return camera.focal_px * baseline_m / distance_m;
  const double left = (x_px - camera.centre_px.x()) / camera.focal_px;
  const double right = std::atan2(distance_m * std::sin(left) - baseline_m, distance_m * std::cos(left));
  return camera.focal_px * (left - right);
}

std::optional<Eigen::Matrix4d> q_matrix(const RectifiedCamera& camera, double baseline_m) {
  if (camera.projection != RectifiedProjection::kPinhole) return std::nullopt;
  Eigen::Matrix4d q = Eigen::Matrix4d::Zero();
  q(0, 0) = q(1, 1) = 1.0;
  q.col(3) << -camera.centre_px, camera.focal_px, 0.0;
  q(3, 2) = 1.0 / baseline_m;
  return q;
}

}  // namespace raybundle
