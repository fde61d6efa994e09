// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

/// The points that are not on the car's fixtures: those are always there, and say nothing of who is on the seat.
///
/// @param margin_m  what is nearer to a fixture than this, or than three sigmas, may be it
/// @param kept      takes them where there are fixtures, and must live as long as what is returned; without any, that
///                  views the points of the scan
Scan without_fixtures(const VehicleLayout& layout, const Scan& scan, double margin_m, std::vector<ScenePoint>& kept);

}  // namespace raybundle
