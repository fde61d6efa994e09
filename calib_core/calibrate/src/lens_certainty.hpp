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

/// Whether a projection that is known no better leaves the lens open: by more than 2 % of the image.
bool leaves_lens_open(ImageSize size, double sigma_px);

/// Refuses a lens of a camera by itself that the views leave open.
///
/// @param sigma_px  projection_sigma_px() of the camera
/// @throws Error(kNotEnoughData)
void refuse_open_lens(const CalibrationProblem& single, const BundleState& state, double sigma_px);

}  // namespace raybundle
