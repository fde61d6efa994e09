// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/zones.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace raybundle {
namespace {

// A dashboard at x = 0.7, zones of 0.2 and 0.4 m, without margin unless a test says so.
ZoneCount count(const std::vector<ScenePoint>& points, ZoneOptions options = {.margin_m = 0.0}) {
  return count_zones({.dashboard_x_m = 0.7}, {.viewpoint_in_vehicle = {0.4, 0.3, 0.9}, .points = points, .rays = 10},
                     options);
}

TEST(Zones, PointsAreCountedByTheirDistanceToTheDashboard) {
  const ZoneCount counted = count({{0, {0.55, 0, 0.5}, 0.005}, {1, {0.4, 0, 0.5}, 0.005}, {2, {0.1, 0, 0.5}, 0.005}});
  EXPECT_EQ(counted.critical, 1);
  EXPECT_EQ(counted.out_of_position, 1);
  EXPECT_TRUE(counted.anything);
  EXPECT_NEAR(counted.distance_m, 0.15, 1e-12);
}

// Knees, the dashboard itself and the driver are not in the airbag's way.
TEST(Zones, WhatIsOutsideDoesNotCount) {
  const ZoneCount counted =
      count({{0, {0.55, 0, 0.2}, 0.005}, {1, {0.695, 0, 0.4}, 0.005}, {2, {0.55, 0.5, 0.5}, 0.005}});
  EXPECT_EQ(counted.critical + counted.out_of_position, 0);
  EXPECT_FALSE(counted.anything);
}

TEST(Zones, TheMarginMakesThemDeeper) {
  const std::vector<ScenePoint> points{{0, {0.48, 0, 0.5}, 0.005}};
  EXPECT_EQ(count(points).critical, 0);
  EXPECT_EQ(count(points, {.margin_m = 0.03}).critical, 1);
}

// Dense points hold single wrong ones: a point without company in its cell of 6 cm is nothing.
TEST(Zones, SinglePointsOfDenseCloudsAreNotBelieved) {
  std::vector<ScenePoint> points{{0, {0.60, 0, 0.5}, 0.005}};
  for (int i = 1; i < 5; ++i) points.push_back({i, {0.4 + 0.002 * i, 0.01, 0.5}, 0.005});
  const ZoneCount counted = count(points, {.margin_m = 0.0, .least_points = 3});
  EXPECT_EQ(counted.critical, 0);
  EXPECT_EQ(counted.out_of_position, 4);
  EXPECT_NEAR(counted.distance_m, 0.296, 1e-12);  // the third nearest
}

// Above the dashboard somebody may lean over it; at its height, what is as near as its noise is the dashboard.
TEST(Zones, OverTheDashboardEverythingCounts) {
  EXPECT_EQ(count({{0, {0.75, 0, 0.60}, 0.005}}).critical, 1);
  EXPECT_EQ(count({{0, {0.75, 0, 0.44}, 0.005}}).critical, 0);
  EXPECT_EQ(count({{0, {0.67, 0, 0.44}, 0.005}}).critical, 1);
  EXPECT_EQ(count({{0, {0.67, 0, 0.44}, 0.050}}).critical, 0);
}

}  // namespace
}  // namespace raybundle
