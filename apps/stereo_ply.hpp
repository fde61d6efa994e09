// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/stereo/stereo.hpp"

namespace raybundle::apps {

/// The points of a pair as PLY, binary, row by row: docs/formats/stereo.md.
std::string stereo_ply(const StereoFrame& frame);

/// The points of such a file; nothing when it is another one, or not all of it.
std::optional<std::vector<StereoPoint>> points_of_stereo_ply(const std::string& bytes);

}  // namespace raybundle::apps
