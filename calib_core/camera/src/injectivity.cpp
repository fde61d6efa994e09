// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/camera/injectivity.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

/// Determinant of pixel against ray on the unit sphere, positive when the image is not mirrored.
template <CameraModel M>
double determinant(const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel) {
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> pixel_wrt_ray;
  Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> pixel_wrt_parameters;
  if (!pixel_from_ray<M>(parameters, ray, pixel, pixel_wrt_ray, pixel_wrt_parameters)) return 0.0;
  const Eigen::Vector3d across = ray.unitOrthogonal();
  const Eigen::Vector3d along = ray.cross(across);
  const Eigen::Vector2d a = pixel_wrt_ray * across;
  const Eigen::Vector2d b = pixel_wrt_ray * along;
  const double mirrored = parameters[0] * parameters[1] < 0 ? -1.0 : 1.0;
  return mirrored * (a.x() * b.y() - a.y() * b.x());
}

/// Angle off the axis of the one ray of a pixel; nothing when there is none, or the projection is folded there.
std::optional<double> angle_of_pixel(const Camera& camera, const Eigen::Vector2d& pixel) {
  constexpr double kRoundTrip_px = 1e-6;  // far above rounding, far below any measurement
  const std::optional<Eigen::Vector3d> ray = ray_from_pixel(camera, pixel);
  if (!ray) return std::nullopt;
  Eigen::Vector2d again;
  const double area =
      with_model(camera.model, [&]<CameraModel M>() { return determinant<M>(camera.parameters.data(), *ray, again); });
  if (!(area > 0) || !((again - pixel).norm() <= kRoundTrip_px)) return std::nullopt;
  return std::atan2(ray->head<2>().norm(), ray->z());
}

}  // namespace

InjectivityReport check_injectivity(const Camera& camera, int samples_per_side) {
  if (camera.size.width < 1 || camera.size.height < 1) {
    throw Error(ErrorKind::kBadInput, "the camera's image size is empty; give its width and height in pixels");
  }
  const auto expected = static_cast<Eigen::Index>(parameter_names(camera.model).size());
  if (camera.parameters.size() != expected) {
    throw Error(ErrorKind::kBadInput, "the camera has " + std::to_string(camera.parameters.size()) +
                                          " parameters; its model " + std::string(model_name(camera.model)) + " has " +
                                          std::to_string(expected));
  }
  const int n = std::max(samples_per_side, 2);
  const Eigen::Vector2d centre(camera.cx(), camera.cy());
  const Eigen::Vector2d step = Eigen::Vector2d(camera.size.width - 1, camera.size.height - 1) / (n - 1);

  InjectivityReport report;
  report.max_angle_rad = max_angle_rad(camera);
  int covered = 0;
  bool border_seen = false;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      const Eigen::Vector2d pixel(step.x() * column, step.y() * row);
      const std::optional<double> angle = angle_of_pixel(camera, pixel);
      const double radius = (pixel - centre).norm();
      if (!angle) {
        if (!report.first_offender || radius < report.first_offender_radius_px) {
          report.first_offender = pixel;
          report.first_offender_radius_px = radius;
        }
        continue;
      }
      ++covered;
      const bool border = row == 0 || column == 0 || row == n - 1 || column == n - 1;
      if (!border) continue;
      report.nearest_border_angle_rad = border_seen ? std::min(report.nearest_border_angle_rad, *angle) : *angle;
      report.farthest_border_angle_rad = std::max(report.farthest_border_angle_rad, *angle);
      border_seen = true;
    }
  }
  report.covered_fraction = static_cast<double>(covered) / (n * n);
  return report;
}

}  // namespace raybundle
