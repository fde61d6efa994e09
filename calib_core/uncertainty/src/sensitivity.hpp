// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/parameter_names.hpp"

namespace raybundle {

/// How a pixel moves with what it depends on.
struct PixelDerivatives {
  Eigen::Matrix<double, 2, 3> by_ray;
  Eigen::Matrix2Xd by_intrinsics;  ///< columns as Camera::parameters
};

/// At the pixel of a ray; nothing where the model does not project it.
std::optional<PixelDerivatives> pixel_derivatives(const Camera& camera, const Eigen::Vector3d& ray);

/// How a point moves with a small motion of everything before the camera: rotation about its centre, translation.
Eigen::Matrix<double, 3, 6> by_motion_of_surroundings(const Eigen::Vector3d& x_in_camera);

/// Adds derivatives by some parameters to the columns where the covariance has them.
///
/// @param derivatives  rows × places
/// @param all          rows × covariance.names
void scatter(const Eigen::Ref<const Eigen::MatrixXd>& derivatives, const std::vector<int>& places,
             Eigen::Ref<Eigen::MatrixXd> all);

}  // namespace raybundle
