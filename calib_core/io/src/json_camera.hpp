// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "json_text.hpp"
#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// Adds to an entry of cameras[] what was estimated: parameters by name, camera_from_rig, sigmas (of what was not
/// fixed).
void add_estimates(const RigCamera& camera, const Covariance& covariance, OrderedJson& entry);

/// Standard deviations of a board's shape, with the keys of json_from_shape(); without those that were fixed.
OrderedJson json_from_shape_sigmas(const Covariance& covariance, const std::string& target);

}  // namespace raybundle
