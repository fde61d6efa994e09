// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "raybundle/stereo/stereo.hpp"

namespace raybundle::apps {

/// Frames that a page shows at most; of a longer sequence the first ones.
inline constexpr int kMostPageFrames = 60;

/// What a page shows of one pair: both images, the disparities, and some thousand of the points.
nlohmann::json stereo_page_frame(const std::string& name, const StereoFrame& frame);

/// A self-contained page about a sequence of pairs: images, disparities and points in space, to be played.
///
/// @param frames  array of stereo_page_frame. Frames may have more: `answer`, as json_of_answer makes it, shows the
///                decision and what it rests on; CabinWatch::on_page() shows zones, boxes and head in an upright car
std::string stereo_page(const nlohmann::json& frames);

}  // namespace raybundle::apps
