// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "sensitivity.hpp"

#include "raybundle/geometry/rotation.hpp"

namespace raybundle {

std::optional<PixelDerivatives> pixel_derivatives(const Camera& camera, const Eigen::Vector3d& ray) {
  return with_model(camera.model, [&]<CameraModel M>() -> std::optional<PixelDerivatives> {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_ray;
    Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> by_intrinsics;
    if (!pixel_from_ray<M>(camera.parameters.data(), ray, pixel, by_ray, by_intrinsics)) return std::nullopt;
    return PixelDerivatives{by_ray, by_intrinsics};
  });
}

Eigen::Matrix<double, 3, 6> by_motion_of_surroundings(const Eigen::Vector3d& x_in_camera) {
  Eigen::Matrix<double, 3, 6> by_motion;
  by_motion << -skew(x_in_camera), Eigen::Matrix3d::Identity();
  return by_motion;
}

void scatter(const Eigen::Ref<const Eigen::MatrixXd>& derivatives, const std::vector<int>& places,
             Eigen::Ref<Eigen::MatrixXd> all) {
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (places[k] >= 0) all.col(places[k]) += derivatives.col(static_cast<Eigen::Index>(k));
  }
}

}  // namespace raybundle
