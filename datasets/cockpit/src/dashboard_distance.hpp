// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/cockpit/cockpit.hpp"

namespace raybundle {

/// The dashboard's plane to the nearest place of the meshes in the zones' height and width [m]; at least 0, infinite
/// where nothing is.
double dashboard_distance(const std::vector<CabinMesh>& meshes, const CabinLayout& layout);

}  // namespace raybundle
