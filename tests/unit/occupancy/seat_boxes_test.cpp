// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/seat_boxes.hpp"

#include <gtest/gtest.h>

namespace raybundle {
namespace {

bool in(const SeatPose& seat, SeatPlace place, const Eigen::Vector2d& x) {
  return seat_boxes(seat)[static_cast<std::size_t>(place)].contains({x.x(), 0.0, x.y()});
}

// What lies on a seat lies in the same box wherever the seat is moved and however it is reclined.
TEST(SeatBoxes, MoveAndReclineWithTheSeat) {
  for (const double recline : {0.25, 0.45, 0.65}) {
    for (const double track : {-0.12, 0.0, 0.12}) {
      const SeatPose seat{{-0.14 + track, -0.10}, recline, 0.2};
      const Eigen::Vector2d along = seat.cushion_forward(), up = seat.back_up();
      const Eigen::Vector2d above(-along.y(), along.x()), before(up.y(), -up.x());
      EXPECT_TRUE(in(seat, SeatPlace::kCushion, seat.bight + 0.25 * along - 0.05 * above));
      EXPECT_TRUE(in(seat, SeatPlace::kBack, seat.bight + 0.30 * up - 0.05 * before));
      EXPECT_TRUE(in(seat, SeatPlace::kAboveCushion, seat.bight + 0.40 * along + 0.10 * above));
      EXPECT_TRUE(in(seat, SeatPlace::kBody, seat.bight + 0.30 * up + 0.12 * before));
      EXPECT_TRUE(in(seat, SeatPlace::kHead, seat.bight + 0.65 * up + 0.15 * before));
      EXPECT_FALSE(in(seat, SeatPlace::kBody, seat.bight + 0.65 * up + 0.15 * before));
    }
  }
}

// Body and head share a border that goes up and down with the chin.
TEST(SeatBoxes, TheChinParts) {
  const auto boxes = seat_boxes({}, 0.42);
  EXPECT_EQ(boxes[static_cast<std::size_t>(SeatPlace::kBody)].high.z(), 0.42);
  EXPECT_EQ(boxes[static_cast<std::size_t>(SeatPlace::kHead)].low.z(), 0.42);
}

}  // namespace
}  // namespace raybundle
