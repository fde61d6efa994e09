// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// Covariance of a solved camera's intrinsics, in the order of its model; zero for those that were not estimated.
Eigen::MatrixXd covariance_of_lens(const CalibrationProblem& single, const BundleState& state, int threads);

/// How well a solved camera knows where it projects the corners that it has seen: root mean square [px] of what the
/// covariance of its intrinsics says, less the common turn that the boards' poses take up.
double projection_sigma_px(const CalibrationProblem& single, const BundleState& state, int threads);

/// Root mean square distance [px] between where two cameras put rays, one of them turned so that they agree best: the
/// boards' poses take up a turn. Infinite where one of them does not project all of them.
double projection_distance_px(const Camera& camera, const Camera& other,
                              const std::vector<Eigen::Vector3d>& rays_in_camera);

/// Refuses a lens of a camera by itself that the views leave open: its projection known no better than to 2 % of the
/// image.
///
/// @param sigma_px  how well its projection is known: CameraOptimum::projection_sigma_px
/// @throws Error(kNotEnoughData)
void refuse_open_lens(const CalibrationProblem& single, const BundleState& state, double sigma_px);

}  // namespace raybundle
