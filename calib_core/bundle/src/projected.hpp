// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/camera/camera.hpp"

namespace raybundle {

/// Pixels of points given in the camera's frame; NaN where the model does not project one.
Eigen::MatrixX2d projected(const Camera& camera, const Eigen::MatrixX3d& points_in_camera);

}  // namespace raybundle
