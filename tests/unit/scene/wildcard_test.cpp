// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/wildcard.hpp"

#include <gtest/gtest.h>

#include <string>

namespace raybundle {
namespace {

TEST(MatchesPattern, StarsAndQuestionMarks) {
  EXPECT_TRUE(matches_pattern("left01.jpg", "left*.jpg"));
  EXPECT_TRUE(matches_pattern("left01.jpg", "left??.jpg"));
  EXPECT_TRUE(matches_pattern("aXbXc", "a*b*c"));
  EXPECT_TRUE(matches_pattern("", "*"));
  EXPECT_FALSE(matches_pattern("left01.png", "left*.jpg"));
  EXPECT_FALSE(matches_pattern("left1.jpg", "left??.jpg"));
  EXPECT_FALSE(matches_pattern("a", ""));
  EXPECT_FALSE(matches_pattern(std::string(3000, 'a'), std::string(1000, '*') + "b"));  // and it comes back soon
}

}  // namespace
}  // namespace raybundle
