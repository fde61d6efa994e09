// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../calib_core/bundle/src/workers.hpp"

#include <gtest/gtest.h>

namespace raybundle {
namespace {

TEST(Workers, CallEachIndexOnceInEveryLoop) {
  for (const int threads : {0, 1, 2, 5}) {
    Workers workers(threads);
    for (const int count : {0, 1, 2, 7, 64, 1000, 0, 3}) {  // batches of 1 to 8 calls, and of none
      std::vector<int> calls(count);
      workers.for_each(count, [&](int i) { ++calls[i]; });
      EXPECT_EQ(calls, std::vector<int>(count, 1)) << threads << " threads";
    }
  }
}

// A solve has some hundred loops of few calls; what one wrote the next one reads, on whichever thread.
TEST(Workers, ALoopSeesWhatTheOneBeforeWrote) {
  Workers workers(4);
  std::vector<int> values(10, 0), next(10);
  for (int loop = 0; loop < 2000; ++loop) {
    workers.for_each(10, [&](int i) { next[i] = values[(i + 1) % 10] + 1; });
    values.swap(next);
  }
  EXPECT_EQ(values, std::vector<int>(10, 2000));
}

TEST(Workers, EndWithoutALoop) { const Workers workers(4); }

}  // namespace
}  // namespace raybundle
