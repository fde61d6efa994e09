// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "raybundle/camera/camera.hpp"

namespace raybundle {

/// How a rectified image shows rays: a point is in the same row of both images.
///
/// kPinhole: x = X/Z, y = Y/Z. Straight lines stay straight, but the sampling grows with 1/cos² towards the rim.
/// kTransverseEquirectangular: x = asin(X/|p|), y = atan2(Y, Z), with the poles on the baseline. Any field of view;
/// what mrcal calls LENSMODEL_LATLON.
enum class RectifiedProjection { kPinhole, kTransverseEquirectangular };

std::string_view rectified_projection_name(RectifiedProjection projection);

/// The projection of that name: pinhole or equirectangular; nothing when there is none.
std::optional<RectifiedProjection> rectified_projection_named(std::string_view name);

/// The camera that both rectified images share: x along the baseline, y down, z forward.
struct RectifiedCamera {
  RectifiedProjection projection = RectifiedProjection::kPinhole;
  ImageSize size;
  double focal_px = 0.0;  ///< px for each unit of slope (pinhole) or for each radian (equirectangular), in x and y
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< pixel of the z axis

  /// Pixel of a ray; nothing for a ray that the projection cannot show. May lie outside of the image.
  std::optional<Eigen::Vector2d> pixel_from_ray(const Eigen::Vector3d& ray) const;

  /// Unit ray of a pixel; nothing beyond a pole.
  std::optional<Eigen::Vector3d> ray_from_pixel(const Eigen::Vector2d& pixel) const;

  bool contains(const Eigen::Vector2d& pixel) const;
};

/// Distance of a matched point: along z for pinhole, from the left camera's centre for equirectangular, so that
/// point = distance · direction_scale(ray) [m].
///
///   pinhole:         z = focal · baseline / disparity
///   equirectangular: r = baseline · cos(x_right) / sin(x_left - x_right),  x in radians
///
/// @param x_px          column in the left image
/// @param disparity_px  > 0, left minus right column
double distance_from_disparity(const RectifiedCamera& camera, double baseline_m, double x_px, double disparity_px);

/// The disparity of a distance: what distance_from_disparity takes back.
double disparity_from_distance(const RectifiedCamera& camera, double baseline_m, double x_px, double distance_m);

/// The 4×4 matrix that takes (u, v, disparity, 1) to homogeneous points, as cv::reprojectImageTo3D wants it; nothing
/// for an equirectangular pair, whose points no matrix gives.
std::optional<Eigen::Matrix4d> q_matrix(const RectifiedCamera& camera, double baseline_m);

}  // namespace raybundle
