// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/geodetic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

const Geodetic kToulouse{43.5642, 1.4811, 196.0};

TEST(Geodetic, ThereAndBack) {
  for (const Geodetic& place : {Geodetic{43.60, 1.45, 150.0}, Geodetic{-80.0, 179.0, 4000.0}, Geodetic{0, -1, 0}}) {
    const Geodetic back = geodetic_from_enu(kToulouse, enu_from_geodetic(kToulouse, place));
    EXPECT_NEAR(back.latitude_deg, place.latitude_deg, 1e-11);
    EXPECT_NEAR(back.longitude_deg, place.longitude_deg, 1e-11);
    EXPECT_NEAR(back.height_m, place.height_m, 1e-6);
  }
}

TEST(Geodetic, AxesPointEastNorthAndUp) {
  EXPECT_GT(enu_from_geodetic(kToulouse, {43.5642, 1.4911, 196.0}).x(), 800.0);
  EXPECT_GT(enu_from_geodetic(kToulouse, {43.5742, 1.4811, 196.0}).y(), 1100.0);
  EXPECT_NEAR(enu_from_geodetic(kToulouse, {43.5642, 1.4811, 296.0}).z(), 100.0, 1e-9);
  EXPECT_LT((enu_from_azimuth(std::numbers::pi / 2, 0.0) - Eigen::Vector3d::UnitX()).norm(), 1e-15);
}

// A landmark 5 km away at the same height lies d² / 2R = 1.96 m below the horizon plane: 0.39 px at f = 1000 px.
TEST(Geodetic, FiveKilometresShowTheCurvatureOfTheEarth) {
  const Eigen::Vector3d x = enu_from_geodetic(kToulouse, {43.5642 + 5000.0 / 111100.0, 1.4811, 196.0});
  EXPECT_NEAR(x.y(), 5000.0, 10.0);
  EXPECT_NEAR(1000.0 * x.z() / x.y(), -0.39, 0.005);
}

TEST(Geodetic, RefusesWhatIsNoPlace) {
  EXPECT_THROW(enu_from_geodetic(kToulouse, {91.0, 0, 0}), Error);
  EXPECT_THROW(enu_from_geodetic({NAN, 0, 0}, kToulouse), Error);
}

}  // namespace
}  // namespace raybundle
