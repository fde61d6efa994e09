// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace raybundle::apps {

/// A page that shows decisions frame by frame: points from the side and from above with the safety zones, the
/// decision and what it rests on; frames can be played. Needs nothing but a browser.
///
/// @param json  `vehicle` (the layout) and `frames`, as `occupancy classify --json` writes them, each with `points`
std::string occupancy_page(const std::string& json);

}  // namespace raybundle::apps
