// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "raybundle/occupancy/box.hpp"
#include "raybundle/occupancy/seat.hpp"

namespace raybundle {

/// The five places on a seat where something may be.
enum class SeatPlace : unsigned char { kCushion, kBack, kAboveCushion, kBody, kHead };
inline constexpr int kSeatPlaces = 5;
inline constexpr std::array<std::string_view, kSeatPlaces> kSeatPlaceNames{"cushion", "back", "above_cushion", "body",
                                                                           "head"};

/// Boxes of a seat as it is set, which they move and recline with, in the order of SeatPlace: the volumes of cushion
/// and back, the place above the cushion before the body, and two along the back, for body and head.
///
/// @param chin_m  height along the back at which the head's box begins and the body's ends
/// Source: Boverie et al., Comparison of structured light and stereovision sensors for new airbag generations, 3.2: two
/// boxes of variable height along the back; sizes are ours
std::array<Box, kSeatPlaces> seat_boxes(const SeatPose& seat, double chin_m = 0.50);

}  // namespace raybundle
