// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "sensitivity.hpp"

#include <algorithm>

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

std::vector<std::string> intrinsic_names(const RigCamera& camera) {
  std::vector<std::string> names;
  for (const std::string_view name : parameter_names(camera.camera.model)) {
    names.push_back(camera.name + "." + std::string(name));
  }
  return names;
}

std::vector<std::string> extrinsic_names(const RigCamera& camera) {
  std::vector<std::string> names;
  for (const char* part :
       {"rotation_x", "rotation_y", "rotation_z", "translation_x", "translation_y", "translation_z"}) {
    names.push_back(camera.name + ".camera_from_rig." + part);
  }
  return names;
}

std::vector<std::string> shape_names(const Target& target) {
  return {target.name + ".bend_x", target.name + ".bend_y", target.name + ".twist"};
}

std::vector<int> places_of(const std::vector<std::string>& names, const Covariance& covariance) {
  std::vector<int> places;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(covariance.names, name);
    places.push_back(found == covariance.names.end() ? -1 : static_cast<int>(found - covariance.names.begin()));
  }
  return places;
}

void scatter(const Eigen::Ref<const Eigen::MatrixXd>& derivatives, const std::vector<int>& places,
             Eigen::Ref<Eigen::MatrixXd> all) {
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (places[k] >= 0) all.col(places[k]) += derivatives.col(static_cast<Eigen::Index>(k));
  }
}

}  // namespace raybundle
