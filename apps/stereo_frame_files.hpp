// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/stereo/stereo.hpp"

namespace raybundle::apps {

/// What one pair of images says, as bytes of files. The formats: docs/formats/stereo.md.
struct StereoFrameFiles {
  std::string left_png;       ///< rectified
  std::string right_png;      ///< rectified
  std::string disparity_png;  ///< 16 bits [disparity_step_px of the JSON: 1/256 px up to 255 px], 0: no match
  std::string depth_png;      ///< 16 bits [mm], 0: no point
  std::string ply;            ///< binary: points with sigma and grey value
  std::string json;
};

/// @param left, right  the paths, for the record
StereoFrameFiles stereo_frame_files(const StereoFrame& frame, const StereoMatcher& matcher, const std::string& left,
                                    const std::string& right, const nlohmann::ordered_json& more);

/// The files as they are called in a folder, with the frame's name before their endings.
std::vector<WholeFile> named_files(const std::filesystem::path& folder, const std::string& name,
                                   const StereoFrameFiles& files);

/// remove_former_frames() of these files.
///
/// @param names  the frames of this run
void remove_former_stereo_frames(const std::filesystem::path& folder, const std::set<std::string>& names);

}  // namespace raybundle::apps
