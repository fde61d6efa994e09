// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <span>
#include <string>

#include "points_json.hpp"

namespace raybundle::apps {

/// Removes what a former run left in the folder of frames that this one has not, and says so: they would be taken for
/// more of the sequence.
///
/// @param format   of the frames' JSON; what is of another stays
/// @param endings  of the files of each frame, behind its name
/// @param names    the frames of this run
void remove_former_frames(const std::filesystem::path& folder, const PointsFormat& format,
                          std::span<const char* const> endings, const std::set<std::string>& names);

}  // namespace raybundle::apps
