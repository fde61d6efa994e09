// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/threads.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace raybundle {
namespace {

TEST(ForEachIndex, CallsEachIndexOnce) {
  for (const int threads : {-1, 0, 1, 2, 5}) {
    for (const std::size_t count : {0, 1, 3, 1000}) {
      std::vector<int> calls(count);
      for_each_index(count, threads, [&](std::size_t i) { ++calls[i]; });
      EXPECT_EQ(calls, std::vector<int>(count, 1)) << threads << " threads";
    }
  }
}

TEST(ForEachIndex, PassesAnExceptionOnWhicheverThreadThrows) {
  for (const int threads : {1, 4}) {
    for (const std::size_t bad : {0, 50, 99}) {
      const auto work = [&](std::size_t i) {
        if (i == bad) throw std::runtime_error("work " + std::to_string(i));
      };
      EXPECT_THROW(for_each_index(100, threads, work), std::runtime_error);
    }
  }
}

TEST(ForEachIndex, HandsNothingOutAfterAnException) {
  int calls = 0;
  EXPECT_THROW(for_each_index(100, 1,
                              [&](std::size_t i) {
                                ++calls;
                                if (i == 3) throw std::runtime_error("work");
                              }),
               std::runtime_error);
  EXPECT_EQ(calls, 4);
}

}  // namespace
}  // namespace raybundle
