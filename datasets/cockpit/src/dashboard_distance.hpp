// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "raybundle/cockpit/cockpit.hpp"

namespace raybundle {

/// Of the meshes in the zones' height and width, the place nearest to the dashboard's plane or farthest beyond it.
std::optional<Eigen::Vector3d> nearest_to_dashboard(const std::vector<CabinMesh>& meshes, const CabinLayout& layout);

/// Its distance from the plane [m]; at least 0, infinite where nothing is.
double dashboard_distance(const std::vector<CabinMesh>& meshes, const CabinLayout& layout);

}  // namespace raybundle
