// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle::apps {

/// A page that shows decisions frame by frame: points from the side and from above with the safety zones, the
/// decision and what it rests on; frames can be played. Needs nothing but a browser.
///
/// @param frames  as `occupancy classify --json` writes them, each with `points`
std::string occupancy_page(const VehicleLayout& layout, const nlohmann::ordered_json& frames);

/// The `points` of a frame.
nlohmann::ordered_json page_points(const std::vector<ScenePoint>& points);

}  // namespace raybundle::apps
