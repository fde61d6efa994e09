// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

// What the parameters of a calibration are called: in its file, its covariance, rules and messages.

/// left.fx, left.fy, ... in the order of Camera::parameters.
std::vector<std::string> intrinsic_names(const std::string& camera, ModelId model);
std::vector<std::string> intrinsic_names(const RigCamera& camera);

/// left.camera_from_rig.rotation_x, ... in the order of perturbed()'s motion.
std::vector<std::string> extrinsic_names(const std::string& camera);
std::vector<std::string> extrinsic_names(const RigCamera& camera);

/// board.bend_x, ... in the order of BoardShape::sags().
std::vector<std::string> shape_names(const std::string& target);

/// The values of all of them, by name. A camera's place is camera_from_rig's rotation vector [rad] and translation [m].
std::map<std::string, double> parameter_values(const Calibration& calibration);

}  // namespace raybundle
