// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/beam_depth.hpp"

#include <cmath>

#include "sensitivity.hpp"

namespace raybundle {

BeamDepth beam_depth(const RigCamera& camera, const Covariance& parameters, const Line3& line,
                     const Eigen::Matrix4d& of_beam, const Eigen::MatrixXd& with_parameters, double depth_m) {
  const Eigen::Matrix3d rotation = camera.camera_from_rig.rotation.toRotationMatrix();
  const auto [start, direction] = camera.camera_from_rig * line;
  if (std::abs(direction.z()) < 1e-6) return {};
  const double along = (depth_m - start.z()) / direction.z();
  const Eigen::Vector3d in_camera = start + along * direction;
  const std::optional<Eigen::Vector2d> pixel = pixel_from_ray(camera.camera, in_camera);
  const std::optional<PixelDerivatives> derivatives = pixel_derivatives(camera.camera, in_camera);
  if (!pixel || !derivatives || !camera.camera.size.contains(*pixel)) return {};

  // A pixel error e moves the dot along the beam by -solve · e.
  const Eigen::Vector2d by_along = derivatives->by_ray * direction;
  if (!(by_along.squaredNorm() > 1e-12)) return {};  // the beam runs along the camera's ray
  const Eigen::RowVector2d solve = by_along.transpose() / by_along.squaredNorm();
  // The dot's place in the camera moves with the beam and with the camera's place on the rig, and then along the beam
  // until it is seen where it was.
  Eigen::Matrix<double, 3, 4> by_beam;
  by_beam.leftCols<2>() = rotation * across(line.direction);
  by_beam.rightCols<2>() = along * by_beam.leftCols<2>();
  const Eigen::Matrix<double, 3, 6> by_place =
      by_motion_of_surroundings(in_camera - camera.camera_from_rig.translation);
  const auto depth_by = [&, &direction = direction](const Eigen::Matrix3Xd& place) -> Eigen::RowVectorXd {
    return place.row(2) - direction.z() * solve * derivatives->by_ray * place;
  };
  const Eigen::RowVector4d depth_by_beam = depth_by(by_beam);
  Eigen::RowVectorXd depth_by_parameters = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(parameters.names.size()));
  scatter(-direction.z() * solve * derivatives->by_intrinsics, parameters.places_of(intrinsic_names(camera)),
          depth_by_parameters);
  scatter(depth_by(by_place), parameters.places_of(extrinsic_names(camera)), depth_by_parameters);

  double variance = (depth_by_beam * of_beam).dot(depth_by_beam);
  if (depth_by_parameters.size() > 0) {
    variance += 2.0 * (depth_by_beam * with_parameters).dot(depth_by_parameters) +
                (depth_by_parameters * parameters.matrix).dot(depth_by_parameters);
  }
  return {std::sqrt(std::max(0.0, variance)), std::abs(direction.z()) / by_along.norm()};
}

}  // namespace raybundle
