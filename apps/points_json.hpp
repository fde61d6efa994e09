// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace raybundle::apps {

/// A kind of file that `reconstruct` writes.
struct PointsFormat {
  std::string_view name;    ///< the file's `format`
  std::string_view sensor;  ///< as `reconstruct` and `occupancy learn --sensor` call it
};
inline constexpr PointsFormat kLaserPoints{"raybundle laser points", "structured-light"};
inline constexpr PointsFormat kStereoPoints{"raybundle stereo points", "stereo"};

inline constexpr double kFarthestPoint_m = 1e4;  ///< what a file holds beyond is damaged

/// Reads JSON of a format.
///
/// @param use  takes what it needs; what is missing there or of another type makes the file a damaged one
/// @throws Error(kIo) when it cannot be read; Error(kBadInput) when it is damaged, or of another format
void read_points_json(const std::string& path, const PointsFormat& format,
                      const std::function<void(const nlohmann::json&)>& use);

}  // namespace raybundle::apps
