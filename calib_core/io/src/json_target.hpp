// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "json_node.hpp"
#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// A target from {name, points: [[id, x, y, z], ...], symmetries: [[id, ...], ...]}; symmetries may be missing.
Target target_from(const JsonNode& node);

/// Targets with their shape {bend_x_m, bend_y_m, twist_m}.
std::vector<CalibratedTarget> calibrated_targets_from(const JsonNode& nodes);

}  // namespace raybundle
