// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/camera/camera.hpp"

namespace raybundle::bench {

/// Root mean square distance [px] between where two cameras put rays, one of them turned so that they agree best: the
/// board poses take up a turn. Infinite when one of them does not project a hundredth of the rays.
///
/// @param rays_in_reference  unit vectors
double projection_difference_px(const Camera& reference, const Camera& other,
                                const std::vector<Eigen::Vector3d>& rays_in_reference);

/// Root mean square standard deviation [px] of a camera's projection of rays, the turn that poses take up removed.
///
/// @param covariance  of camera.parameters
double projection_sigma_px(const Camera& camera, const Eigen::MatrixXd& covariance,
                           const std::vector<Eigen::Vector3d>& rays_in_camera);

}  // namespace raybundle::bench
