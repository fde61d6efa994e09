// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/board_surface.hpp"

#include <gtest/gtest.h>

#include <random>

#include "raybundle/geometry/error.hpp"
#include "synthetic_world.hpp"

namespace raybundle {
namespace {

const Target kBoard = testing::grid_target("board", 9, 7, 0.04);
const BoardShape kBent{.bend_x_m = 0.004, .bend_y_m = -0.003, .twist_m = 0.002};

TEST(BoardSurface, PassesThroughTheBentPoints) {
  const BoardSurface surface(kBoard);
  for (const Eigen::Vector3d& x : points_on_surface(kBoard, kBent)) {
    EXPECT_NEAR(surface.height(x.x(), x.y(), kBent), x.z(), 1e-15);
    EXPECT_TRUE(surface.covers(x, 1e-12));
  }
  EXPECT_FALSE(surface.covers({-0.01, 0.0, 0.0}));
  EXPECT_TRUE(surface.covers({-0.01, 0.0, 0.0}, 0.02));
}

TEST(BoardSurface, NormalIsTheGradient) {
  const BoardSurface surface(kBoard);
  const double h = 1e-5;
  const Eigen::Vector3d normal = surface.normal(0.05, 0.2, kBent);
  // The surface is quadratic, so that central differences are exact up to rounding.
  EXPECT_NEAR(-normal.x(), (surface.height(0.05 + h, 0.2, kBent) - surface.height(0.05 - h, 0.2, kBent)) / (2 * h),
              1e-10);
  EXPECT_NEAR(-normal.y(), (surface.height(0.05, 0.2 + h, kBent) - surface.height(0.05, 0.2 - h, kBent)) / (2 * h),
              1e-10);
}

TEST(BoardSurface, CrossingLiesOnLineAndSurface) {
  const BoardSurface surface(kBoard);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.1, 0.5);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d from(place(random), place(random), -0.5);
    const Eigen::Vector3d to(place(random), place(random), 0.1);
    const Line3 line{from, (to - from).normalized()};
    const std::optional<Eigen::Vector3d> x = surface.crossing(line, kBent);
    ASSERT_TRUE(x.has_value());
    EXPECT_LT(distance_between(line, *x), 1e-14);
    EXPECT_NEAR(x->z(), surface.height(x->x(), x->y(), kBent), 1e-14);
  }
  EXPECT_FALSE(surface.crossing({{0, 0, 1}, {1, 0, 0}}, kBent).has_value());
}

TEST(BoardSurface, IsRefusedToTargetsThatAreNotFlat) {
  Target target = kBoard;
  target.points[3].x_in_target.z() = 0.01;
  EXPECT_THROW(BoardSurface{target}, Error);
}

}  // namespace
}  // namespace raybundle
