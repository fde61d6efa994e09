// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "raybundle/stereo/stereo.hpp"

namespace raybundle::apps {

/// Frames that a page shows at most; of a longer sequence the first ones.
inline constexpr int kMostPageFrames = 60;

/// What a page shows of one pair: the left image, its disparities, and some thousand of its points.
nlohmann::json stereo_page_frame(const std::string& name, const StereoFrame& frame);

/// A self-contained page about a sequence of pairs: images, disparities and points in space, to be played.
///
/// @param frames  array of stereo_page_frame
std::string stereo_page(const nlohmann::json& frames);

}  // namespace raybundle::apps
