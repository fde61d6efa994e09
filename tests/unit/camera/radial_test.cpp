// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/camera/radial.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace raybundle {
namespace {

TEST(SolveIncreasing, FindsTheRootWhereNewtonAloneWouldLeaveTheBracket) {
  const auto steep_then_flat = [](double x) {
    return ValueAndSlope{std::atan(20 * (x - 0.9)), 20 / (1 + 400 * (x - 0.9) * (x - 0.9))};
  };
  EXPECT_NEAR(solve_increasing(steep_then_flat, 0.0, 0.0, 10.0, 9.0), 0.9, 1e-14);
  EXPECT_NEAR(solve_increasing(steep_then_flat, 0.5, 0.0, 10.0, 0.0), 0.9 + std::tan(0.5) / 20, 1e-14);
}

TEST(FirstRoot, FindsTheSmallestOfTwoCloseRoots) {
  // (u - 0.5) (u - 0.5003) (u + 1): a scan with 256 steps would miss both
  const std::array<double, 4> a{0.5 * 0.5003, 0.5 * 0.5003 - 1.0003, 1.0 - 1.0003, 1.0};
  EXPECT_NEAR(first_root(bernstein_to_limit(a, 1.0)), 0.5, 1e-10);
  const double v = first_root(bernstein_to_infinity(a));
  EXPECT_NEAR(v / (1 - v), 0.5, 1e-10);
}

TEST(FirstRoot, IsInfiniteWithoutRoot) {
  EXPECT_EQ(first_root(bernstein_to_infinity(std::array<double, 4>{1, 0, 0, 0})),
            std::numeric_limits<double>::infinity());
  EXPECT_EQ(first_root(bernstein_to_infinity(std::array<double, 4>{1, -1, 1, 0})),
            std::numeric_limits<double>::infinity());
}

TEST(FirstRoot, AgreesWithADenseScan) {
  std::mt19937 random(3);
  std::normal_distribution<double> coefficient(0.0, 1.0);
  for (int trial = 0; trial < 300; ++trial) {
    std::array<double, 7> a{1.0};
    for (std::size_t i = 1; i < a.size(); ++i) a[i] = coefficient(random);
    const double limit = 3.0;
    const double root = first_root(bernstein_to_limit(a, limit)) * limit;
    const auto value = [&](double u) {
      double sum = 0;
      for (std::size_t i = a.size(); i-- > 0;) sum = sum * u + a[i];
      return sum;
    };
    const double end = std::min(root, limit);
    for (double u = 0; u < end - 1e-9; u += 1e-3) ASSERT_GT(value(u), 0) << trial << " " << u;
    EXPECT_TRUE(!std::isfinite(root) || std::abs(value(root)) < 1e-9) << trial;
  }
}

TEST(FirstRoot, ReturnsWithNotANumber) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < 5; ++i) {
    std::array<double, 5> c{1, -1, 1, -1, 1};
    c[i] = kNan;
    first_root(c);
  }
  SUCCEED();
}

}  // namespace
}  // namespace raybundle
