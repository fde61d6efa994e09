// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// How well a dot's depth is known where a camera's ray and a beam meet, both being as uncertain as the calibration
/// says, together: the depth is the least-squares one in the image, z of the camera's frame.
///
/// @param parameters       covariance of the cameras' parameters
/// @param of_beam          covariance of the motion of perturbed(line, .)
/// @param with_parameters  4 × names: of that motion with the parameters
/// @param depth_m          of the dot
/// @return                 NaN where the camera does not see the beam at that depth
BeamDepth beam_depth(const RigCamera& camera, const Covariance& parameters, const Line3& line,
                     const Eigen::Matrix4d& of_beam, const Eigen::MatrixXd& with_parameters, double depth_m);

}  // namespace raybundle
