// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/targets/detect.hpp"

namespace raybundle::apps {

/// What was found in one image, once for each board; for a video one entry for each frame.
struct CachedFrame {
  std::string frame;
  int width = 0;
  int height = 0;
  std::vector<Detection> boards;
};

/// Key of a file's detections: its content, the boards and the version of the detectors.
std::string cache_key(const std::string& file_sha256, const std::vector<Board>& boards);

/// Where detections are kept: $XDG_CACHE_HOME/raybundle/detections or ~/.cache/raybundle/detections.
std::string cache_folder();

/// The text of a cache entry; nothing when it is damaged, or not of these boards.
std::optional<std::vector<CachedFrame>> cached_from_text(std::string_view text, const std::vector<Board>& boards);

inline constexpr int kDaysInCache = 90;  ///< without a run that uses it an entry is deleted by the next one that writes

/// The detections under a key; nothing when there are none or the entry is damaged.
std::optional<std::vector<CachedFrame>> read_cached(const std::string& key, const std::vector<Board>& boards);

/// Keeps detections. A cache that cannot be written is no error: the next run detects again.
void write_cached(const std::string& key, const std::vector<CachedFrame>& frames);

}  // namespace raybundle::apps
