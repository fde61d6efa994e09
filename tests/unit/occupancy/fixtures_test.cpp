// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/fixtures.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace raybundle {
namespace {

constexpr double kMargin_m = 0.04;

VehicleLayout with_screen() {
  VehicleLayout layout;
  layout.fixtures[1] = Eigen::AlignedBox3d(Eigen::Vector3d(0.70, 0.20, 0.45), Eigen::Vector3d(0.75, 0.30, 0.60));
  return layout;
}

bool is_kept(const VehicleLayout& layout, const Eigen::Vector3d& x, double sigma_m) {
  const std::vector<ScenePoint> points{{7, x, sigma_m}};
  std::vector<ScenePoint> kept;
  const Scan scan = without_fixtures(layout, {{0.46, 0.34, 0.90}, points, 1000, State::kDegraded}, kMargin_m, kept);
  EXPECT_EQ(scan.rays, 1000);
  EXPECT_EQ(scan.state, State::kDegraded);
  return !scan.points.empty() && scan.points[0].ray == 7;
}

TEST(Fixtures, DoNotCount) {
  EXPECT_FALSE(is_kept(with_screen(), {0.72, 0.25, 0.50}, 0.001));
  EXPECT_TRUE(is_kept({}, {0.72, 0.25, 0.50}, 0.001));
}

TEST(Fixtures, AreAsLargeAsTheirMarginOrThreeSigmas) {
  EXPECT_FALSE(is_kept(with_screen(), {0.665, 0.25, 0.50}, 0.001));
  EXPECT_TRUE(is_kept(with_screen(), {0.655, 0.25, 0.50}, 0.001));
  EXPECT_FALSE(is_kept(with_screen(), {0.655, 0.25, 0.50}, 0.016));
}

}  // namespace
}  // namespace raybundle
