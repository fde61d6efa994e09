// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/suggestion.hpp"

#include <gtest/gtest.h>

namespace raybundle {
namespace {

const std::vector<std::string> kNames{"columns", "rows", "square_m", "marker_m"};

TEST(Suggestion, FindsCommonMisspellings) {
  EXPECT_EQ(closest("colums", kNames), "columns");
  EXPECT_EQ(closest("colunms", kNames), "columns");
  EXPECT_EQ(closest("Rows", kNames), "rows");
  EXPECT_EQ(closest("square", kNames), "square_m");
  EXPECT_EQ(closest("square_mm", kNames), "square_m");
}

TEST(Suggestion, KeepsQuietWhenNothingIsNear) {
  EXPECT_EQ(closest("dictionary", kNames), std::nullopt);
  EXPECT_EQ(closest("", kNames), std::nullopt);
  EXPECT_EQ(closest("x", kNames), std::nullopt);
  EXPECT_EQ(closest(std::string(1'000'000, 'c'), kNames), std::nullopt);
  EXPECT_EQ(closest("rows", {}), std::nullopt);
}

TEST(Suggestion, EndsAMessage) {
  EXPECT_EQ(did_you_mean("colums", kNames), " Did you mean \"columns\"?");
  EXPECT_EQ(did_you_mean("dictionary", kNames), " Known: columns, rows, square_m, marker_m.");
  EXPECT_EQ(did_you_mean("dictionary", {}), "");
}

}  // namespace
}  // namespace raybundle
