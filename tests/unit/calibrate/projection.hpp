// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/scene/calibration.hpp"

namespace raybundle::testing {

/// Root mean square distance [px] between where two cameras put rays, one of them turned so that they agree best: the
/// board poses take up a turn. Infinite when one of them does not project a hundredth of the rays.
///
/// @param rays_in_reference  unit vectors
double projection_difference_px(const Camera& reference, const Camera& other,
                                const std::vector<Eigen::Vector3d>& rays_in_reference);

/// The block of a covariance that belongs to a camera's intrinsics; zero for those that were not estimated.
Eigen::MatrixXd covariance_of_intrinsics(const Covariance& covariance, const std::string& camera, ModelId model);

/// Root mean square standard deviation [px] of a camera's projection of rays, the turn that poses take up removed.
///
/// @param covariance  of camera.parameters
double projection_sigma_px(const Camera& camera, const Eigen::MatrixXd& covariance,
                           const std::vector<Eigen::Vector3d>& rays_in_camera);

}  // namespace raybundle::testing
