// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// Levenberg-Marquardt on the chords between measured and predicted unit rays (2 sin(angle / 2): right up to 180°).
///
/// @param pose        camera_from_target, improved in place
/// @param scale_rad   scale of a Geman-McClure loss, so that wrong pairs lose their pull; 0: plain least squares
/// @param settled     stops when an iteration lowers the cost by less than this share
/// @return            what is minimised: the sum of the squared chords [rad² for small angles], each damped by the loss
double refine_on_rays(std::span<const Eigen::Vector3d> points_in_target,
                      std::span<const Eigen::Vector3d> rays_in_camera, Rigid3& pose, int max_iterations,
                      double scale_rad = 0.0, double settled = 1e-9);

}  // namespace raybundle
