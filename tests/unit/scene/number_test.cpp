// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/number.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace raybundle {
namespace {

TEST(NumberFrom, IsWhatTheWholeTextSays) {
  EXPECT_EQ(number_from<double>("0.5"), 0.5);
  EXPECT_EQ(number_from<double>("+0.5"), 0.5);
  EXPECT_EQ(number_from<double>("-1e-3"), -1e-3);
  EXPECT_EQ(number_from<double>("inf"), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(number_from<double>("nan").value()));
  EXPECT_EQ(number_from<int>("-7"), -7);
  EXPECT_EQ(number_from<int>("+7"), 7);
  EXPECT_EQ(number_from<double>(std::string_view("12x9").substr(0, 2)), 12);
}

TEST(NumberFrom, RefusesWhatIsMoreOrLessThanANumber) {
  for (const char* text : {"", "+", "-", "+-5", "++5", "--5", "-+5", " 5", "5 ", "5x", "0,5", "0x10", "one", "1e999"}) {
    EXPECT_FALSE(number_from<double>(text)) << text;
  }
  for (const char* text : {"", "1.0", "1e3", "2147483648", "+-5", " 1"}) EXPECT_FALSE(number_from<int>(text)) << text;
  EXPECT_FALSE(number_from<double>(std::string("5\0", 2)));
}

TEST(TwoNumbersFrom, StandOnBothSidesOfTheSign) {
  EXPECT_EQ(two_numbers_from<int>("11x9", 'x'), (std::array{11, 9}));
  EXPECT_EQ(two_numbers_from<double>("320.5,-240", ','), (std::array{320.5, -240.0}));
  for (const char* text : {"", "x", "11", "11x", "x9", "11x9x", "11x9 ", "11 x9", "11X9"}) {
    EXPECT_FALSE(two_numbers_from<int>(text, 'x')) << text;
  }
}

}  // namespace
}  // namespace raybundle
