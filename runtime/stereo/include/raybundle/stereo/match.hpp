// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace raybundle {

/// What became of a pixel.
enum class Match : std::uint8_t {
  kUncovered = 0,  ///< the camera's image does not show the ray
  kMatched = 1,
  kWeak,       ///< the best cost is too high
  kAmbiguous,  ///< another disparity is nearly as good
  kFlat,       ///< the cost hardly rises beside the best disparity, or does not change at all: there is no texture
  kOneSided,   ///< the right image's pixel belongs to another one, or its best disparity is at an end of the range
  kIsolated,   ///< its region is too small
};
inline constexpr int kMatchKinds = 7;

/// uncovered, matched, weak, ambiguous, flat, one_sided or isolated.
std::string_view match_name(Match match);

}  // namespace raybundle
