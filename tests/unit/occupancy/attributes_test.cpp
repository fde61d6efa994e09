// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/attributes.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace raybundle {
namespace {

// A patch of so many points at a distance from the dashboard, in one of the cells of 6 cm in which they are counted.
std::vector<ScenePoint> patch(const VehicleLayout& layout, double distance_m, int count) {
  std::vector<ScenePoint> points;
  for (int i = 0; i < count; ++i) {
    points.push_back({i, {layout.dashboard_x_m - distance_m, 0.001 * i, layout.zone_floor_m + 0.05}, 0.002});
  }
  return points;
}

// The first attribute of dense points.
double nearest_m(const VehicleLayout& layout, const std::vector<ScenePoint>& points) {
  const Scan scan{.viewpoint_in_vehicle = {0.46, 0.34, 0.90}, .points = points, .rays = 1000};
  return kBoxes.attributes(layout, SeatPose{}, scan)[0];
}

TEST(Attributes, AreAsManyAsTheirSetSays) {
  const VehicleLayout layout;
  const std::vector<ScenePoint> points = patch(layout, 0.3, 50);
  const Scan scan{.viewpoint_in_vehicle = {0.46, 0.34, 0.90}, .points = points, .rays = 1000};
  for (const AttributeSet* set : {&kStripes, &kBoxes}) {
    const Attributes attributes = set->attributes(layout, SeatPose{}, scan);
    EXPECT_EQ(attributes.size(), set->size);
    EXPECT_TRUE(attributes.allFinite());
    EXPECT_EQ(attribute_set_named(set->name), set);
  }
}

TEST(Attributes, OfDensePointsTellTheNearestPlaceThatIsBelieved) {
  const VehicleLayout layout;
  constexpr double kFar_m = 0.80;
  EXPECT_NEAR(nearest_m(layout, patch(layout, 0.25, 30)), 0.25, 1e-12);
  EXPECT_EQ(nearest_m(layout, {}), kFar_m);
  EXPECT_EQ(nearest_m(layout, patch(layout, 0.25, 5)), kFar_m);   // wrong matches are few in a place
  EXPECT_EQ(nearest_m(layout, patch(layout, 0.03, 30)), kFar_m);  // the dashboard itself
}

}  // namespace
}  // namespace raybundle
