// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/quantile.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace raybundle {
namespace {

TEST(Quantile, IsOneOfTheValuesWhateverTheirOrder) {
  std::vector<double> odd{3, 1, 2};
  std::vector<double> even{4, 2, 1, 3};
  EXPECT_EQ(median(odd), 2);
  EXPECT_EQ(median(even), 2);  // the lower of the two in the middle
  EXPECT_EQ(quantile(even, 0.0), 1);
  EXPECT_EQ(quantile(even, 0.7), 3);
  EXPECT_EQ(quantile(even, 1.0), 4);
}

TEST(Quantile, OfNoValuesIsInfinite) {
  std::vector<double> none;
  EXPECT_TRUE(std::isinf(median(none)));
}

}  // namespace
}  // namespace raybundle
