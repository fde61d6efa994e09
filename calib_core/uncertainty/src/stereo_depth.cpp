// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/stereo_depth.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "sensitivity.hpp"

namespace raybundle {
StereoDepth stereo_depth(const RigCamera& first, const RigCamera& second, const Covariance& covariance,
                         const Eigen::Vector2d& pixel_in_first, double depth_m) {
  const std::optional<Eigen::Vector3d> ray = ray_from_pixel(first.camera, pixel_in_first);
  if (!ray || !(ray->z() > 1e-6)) return {};
  const Rigid3 second_from_first = second.camera_from_rig * first.camera_from_rig.inverse();
  const Eigen::Vector3d in_first = depth_m / ray->z() * *ray;
  const Eigen::Vector3d in_second = second_from_first * in_first;
  const std::optional<Eigen::Vector2d> pixel_in_second = pixel_from_ray(second.camera, in_second);
  if (!pixel_in_second || !second.camera.size.contains(*pixel_in_second)) return {};
  const auto of_first = pixel_derivatives(first.camera, in_first);
  const auto of_second = pixel_derivatives(second.camera, in_second);
  if (!of_first || !of_second) return {};

  // Both pixels by the point, in the first camera's axes.
  Eigen::Matrix<double, 4, 3> by_point;
  by_point << of_first->by_ray, of_second->by_ray * second_from_first.rotation.toRotationMatrix();
  const Eigen::ColPivHouseholderQR<Eigen::Matrix<double, 4, 3>> triangulation(by_point);
  if (triangulation.rank() < 3) return {};
  const Eigen::RowVector4d depth_by_pixels = triangulation.solve(Eigen::Matrix4d::Identity()).row(2);

  // The predicted pixels by the parameters, while the point stays in the first camera's frame: a motion of the second
  // camera moves the point in it, one of the first moves it in the rig.
  Eigen::MatrixXd predicted = Eigen::MatrixXd::Zero(4, static_cast<Eigen::Index>(covariance.names.size()));
  const auto moves = [](const RigCamera& camera, const Eigen::Vector3d& in_camera) {
    return by_motion_of_surroundings(in_camera - camera.camera_from_rig.translation);
  };
  scatter(of_first->by_intrinsics, covariance.places_of(intrinsic_names(first)), predicted.topRows<2>());
  scatter(of_second->by_intrinsics, covariance.places_of(intrinsic_names(second)), predicted.bottomRows<2>());
  scatter(of_second->by_ray * moves(second, in_second), covariance.places_of(extrinsic_names(second)),
          predicted.bottomRows<2>());
  scatter(-of_second->by_ray * second_from_first.rotation.toRotationMatrix() * moves(first, in_first),
          covariance.places_of(extrinsic_names(first)), predicted.bottomRows<2>());

  const Eigen::RowVectorXd depth_by_parameters = -depth_by_pixels * predicted;
  const double variance =
      predicted.cols() > 0 ? (depth_by_parameters * covariance.matrix).dot(depth_by_parameters) : 0.0;
  return {std::sqrt(std::max(0.0, variance)), depth_by_pixels.norm()};
}

}  // namespace raybundle
