// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/wilson.hpp"

#include <gtest/gtest.h>

#include <array>

namespace raybundle {
namespace {

constexpr double kSigmas = 1.959964;  // of 95 %

// Newcombe, Statistics in Medicine 17 (1998), table I, method 3: as printed, to four digits.
TEST(WilsonBound, IsWhatNewcombePrints) {
  struct Printed {
    double right, trials, low, high;
  };
  constexpr std::array<Printed, 4> kTable{
      {{81, 263, 0.2553, 0.3662}, {15, 148, 0.0624, 0.1605}, {0, 20, 0.0000, 0.1611}, {1, 29, 0.0061, 0.1718}}};
  for (const Printed& row : kTable) {
    EXPECT_NEAR(wilson_bound(row.right / row.trials, row.trials, -kSigmas), row.low, 5.1e-5) << row.trials;
    EXPECT_NEAR(wilson_bound(row.right / row.trials, row.trials, kSigmas), row.high, 5.1e-5) << row.trials;
  }
}

TEST(WilsonBound, OfNoTrialsSaysNothing) {
  EXPECT_EQ(wilson_bound(0.5, 0, -kSigmas), 0.0);
  EXPECT_EQ(wilson_bound(0.5, 0, kSigmas), 1.0);
}

TEST(WilsonBound, StaysAShareAndMirrors) {
  for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    const double low = wilson_bound(share, 7, -kSigmas), high = wilson_bound(share, 7, kSigmas);
    EXPECT_TRUE(0.0 <= low && low <= share && share <= high && high <= 1.0) << share;
    EXPECT_NEAR(wilson_bound(1 - share, 7, kSigmas), 1 - low, 1e-15);  // rounding
  }
}

}  // namespace
}  // namespace raybundle
