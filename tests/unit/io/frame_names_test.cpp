// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/frame_names.hpp"

#include <gtest/gtest.h>

namespace raybundle::testing {
namespace {

using Names = std::vector<std::string>;

TEST(FrameNames, AreTheDigitsThatDiffer) {
  EXPECT_EQ(frame_names({"left03.jpg", "left12.jpg"}), (Names{"3", "12"}));
  EXPECT_EQ(frame_names({"cam2/run7_000.png", "cam2/run7_001.png"}), (Names{"0", "1"}));
  EXPECT_EQ(frame_names({"s1_f01.png", "s2_f01.png", "s1_f02.png"}), (Names{"1-1", "2-1", "1-2"}));
  EXPECT_EQ(frame_names({"01/left.png", "02/left.png"}), (Names{"1", "2"}));
  EXPECT_EQ(frame_names({"cam0_7.png"}), (Names{"7"}));
  EXPECT_EQ(frame_names({"near.png", "far.png"}), (Names{"near", "far"}));
  EXPECT_EQ(frame_names({"a1.png", "a1_2.png"}), (Names{"a1", "a1_2"}));
  EXPECT_EQ(frame_names({}), Names{});
}

TEST(FrameNames, ZeroIsAFrame) { EXPECT_EQ(frame_names({"f000.png", "f100.png"}), (Names{"0", "100"})); }

TEST(FrameNames, NumbersTellMomentsApartWhenNoneIsCommon) {
  EXPECT_TRUE(numbered_apart("day2/left05.jpg", "day2/right12.jpg"));
  EXPECT_FALSE(numbered_apart("left05.jpg", "right5.jpg"));
  EXPECT_FALSE(numbered_apart("cam0_005.png", "cam1_005.png"));
  EXPECT_FALSE(numbered_apart("left.jpg", "right12.jpg"));
}

}  // namespace
}  // namespace raybundle::testing
