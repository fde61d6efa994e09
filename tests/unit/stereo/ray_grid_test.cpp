// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/ray_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kDegree = M_PI / 180.0;

RectifiedCamera camera_of(RectifiedProjection projection, ImageSize size, double focal_px) {
  return {projection, size, focal_px, {0.5 * size.width - 0.3, 0.5 * size.height + 0.2}};
}

// A wall at z = 1 m that every pixel sees.
std::vector<StereoPoint> wall(const RectifiedCamera& camera) {
  std::vector<StereoPoint> points;
  for (int v = 0; v < camera.size.height; ++v) {
    for (int u = 0; u < camera.size.width; ++u) {
      const Eigen::Vector3d ray = *camera.ray_from_pixel({u, v});
      const Eigen::Vector3f x = (ray / ray.z()).cast<float>();
      points.push_back({x.x(), x.y(), x.z(), 0.01F});
    }
  }
  return points;
}

ImageView<const StereoPoint> view_of(const std::vector<StereoPoint>& points, ImageSize size) {
  return {points.data(), size.width, size.height, size.width};
}

bool same(const StereoPoint& a, const StereoPoint& b) {
  return a.x_m == b.x_m && a.y_m == b.y_m && a.z_m == b.z_m && a.sigma_m == b.sigma_m;
}

constexpr RayGridOptions kGrid{.rays_per_rad = 60, .field_x_rad = 100 * kDegree, .field_y_rad = 100 * kDegree};

TEST(RayGrid, LeavesPixelsOfItsDensityAsTheyAre) {
  const auto camera = camera_of(RectifiedProjection::kTransverseEquirectangular, {90, 80}, 61.0);
  std::vector<StereoPoint> points = wall(camera);
  points[1234].sigma_m = 0;
  RayGrid grid(camera, kGrid);
  ASSERT_EQ(grid.columns(), 90);
  ASSERT_EQ(grid.rows(), 80);
  EXPECT_EQ(grid.pixels(), 1.0);
  const auto thinned = grid.thin(view_of(points, camera.size));
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(i == 1234 || same(thinned[i], points[i])) << i;
  }
  EXPECT_EQ(thinned[1234].sigma_m, 0);
}

// Each ray's point is one that was measured, and lies where the ray of a camera of the grid's density would meet the
// wall, to the side of a cell; a pinhole's rim, too, is as dense as its centre.
TEST(RayGrid, IsEquallyDenseInAngle) {
  for (const auto projection : {RectifiedProjection::kPinhole, RectifiedProjection::kTransverseEquirectangular}) {
    const auto camera = camera_of(projection, {400, 300}, 250.0);
    const std::vector<StereoPoint> points = wall(camera);
    RayGrid grid(camera, kGrid);
    const auto thinned = grid.thin(view_of(points, camera.size));
    double last = -10.0;
    const int row = grid.rows() / 2;
    for (int column = 0; column < grid.columns(); ++column) {
      const StereoPoint& point = thinned[static_cast<std::size_t>(row * grid.columns() + column)];
      ASSERT_GT(point.sigma_m, 0) << column;
      const double angle = std::atan2(point.x_m, std::hypot(point.y_m, point.z_m));
      if (column > 1) {
        EXPECT_NEAR(angle - last, 1 / 60.0, 1 / 60.0) << column;
      }
      EXPECT_GT(angle, last);
      last = angle;
    }
    const double half = 200 / 250.0, rim = projection == RectifiedProjection::kPinhole ? std::atan(half) : half;
    EXPECT_NEAR(last, rim, 2 / 60.0);
  }
}

TEST(RayGrid, TakesTheMedianAndNoMinority) {
  const auto camera = camera_of(RectifiedProjection::kTransverseEquirectangular, {300, 300}, 300.0);
  const std::vector<StereoPoint> all = wall(camera);
  RayGrid grid(camera, kGrid);
  EXPECT_NEAR(grid.pixels(), 5.0, 1e-12);
  const int middle = grid.rows() / 2 * grid.columns() + grid.columns() / 2;
  const StereoPoint kept = grid.thin(view_of(all, camera.size))[static_cast<std::size_t>(middle)];
  // The 25 pixels of the ray in the middle: a wrong match is outvoted, and of twelve pixels nothing is kept.
  std::vector<StereoPoint> wrong = all, few = all;
  int changed = 0;
  for (int v = 148; v <= 152; ++v) {
    for (int u = 148; u <= 152; ++u, ++changed) {
      StereoPoint& point = wrong[static_cast<std::size_t>(v * 300 + u)];
      if (changed < 10) point = {0.1F * point.x_m, 0.1F * point.y_m, 0.1F * point.z_m, 0.01F};
      if (changed < 13) few[static_cast<std::size_t>(v * 300 + u)].sigma_m = 0;
    }
  }
  const StereoPoint outvoted = grid.thin(view_of(wrong, camera.size))[static_cast<std::size_t>(middle)];
  EXPECT_NEAR(outvoted.z_m, kept.z_m, 0.01);
  EXPECT_EQ(grid.thin(view_of(few, camera.size))[static_cast<std::size_t>(middle)].sigma_m, 0);
}

TEST(RayGrid, KeepsItsField) {
  const auto camera = camera_of(RectifiedProjection::kTransverseEquirectangular, {160, 170}, 60.0);
  const RayGrid grid(camera, kGrid);
  EXPECT_NEAR(grid.columns(), 60 * 100 * kDegree, 1.0);
  EXPECT_NEAR(grid.rows(), 60 * 100 * kDegree, 1.0);
}

TEST(RayGrid, RefusesACameraOfTooFewPixels) {
  const auto camera = camera_of(RectifiedProjection::kTransverseEquirectangular, {40, 40}, 40.0);
  EXPECT_THROW(RayGrid(camera, kGrid), Error);
}

}  // namespace
}  // namespace raybundle
