// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/box.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace raybundle {
namespace {

// Rays from above a unit cube that end in front of it, in it, behind it and beside it.
TEST(Box, CountsWhatEndsInItPassesItOrIsBlocked) {
  const Box box{.low = {0, 0, 0}, .high = {1, 1, 1}};
  const std::vector<ScenePoint> points{{0, {0.5, 0.5, 1.5}, 0.01},   // ends above: blocked
                                       {1, {0.5, 0.5, 0.5}, 0.01},   // ends inside
                                       {2, {0.5, 0.5, -0.5}, 0.01},  // passed
                                       {3, {0.6, 0.5, -0.5}, 0.01},  // passed
                                       {4, {3.0, 0.5, 0.5}, 0.01}};  // never meets it
  const BoxCount count = count_rays(box, {.viewpoint_in_vehicle = {0.5, 0.5, 3}, .points = points, .rays = 5});
  EXPECT_EQ(count.hits, 1);
  EXPECT_EQ(count.passed, 2);
  EXPECT_EQ(count.blocked, 1);
  EXPECT_DOUBLE_EQ(count.filled(0.0, 0.0), 1.0 / 3);
  EXPECT_DOUBLE_EQ(count.visible(), 3.0 / 4);
}

// What nothing saw is as full as the prior says, not empty.
TEST(Box, UnseenIsNotEmpty) {
  const BoxCount blocked{.blocked = 50};
  EXPECT_DOUBLE_EQ(blocked.filled(0.4, 2.0), 0.4);
  EXPECT_DOUBLE_EQ(blocked.visible(), 0.0);
}

// A box whose x axis rises by 30° holds the point along that axis, and not its mirror image.
TEST(Box, PitchRaisesItsXAxis) {
  const double pitch = M_PI / 6;
  const Box box{.origin = {1, 0, 2}, .pitch_rad = pitch, .low = {0, -1, -0.01}, .high = {1, 1, 0.01}};
  EXPECT_TRUE(box.contains(box.origin + Eigen::Vector3d(0.9 * std::cos(pitch), 0, 0.9 * std::sin(pitch))));
  EXPECT_FALSE(box.contains(box.origin + Eigen::Vector3d(0.9 * std::cos(pitch), 0, -0.9 * std::sin(pitch))));
}

}  // namespace
}  // namespace raybundle
