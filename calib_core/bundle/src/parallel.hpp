// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace raybundle {

/// Calls function(i) for i in [0, count), in any order, on that many threads. The calls must not depend on each other
/// and must not throw.
template <typename Function>
void parallel_for(int count, int threads, const Function& function) {
  constexpr int kBatch = 4;  // a view takes some ten microseconds: not worth a thread, nor an atomic, each
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int begin = next.fetch_add(kBatch); begin < count; begin = next.fetch_add(kBatch)) {
      for (int i = begin; i < std::min(begin + kBatch, count); ++i) function(i);
    }
  };
  std::vector<std::jthread> others;
  for (int t = 1; t < std::min(threads, (count + kBatch - 1) / kBatch); ++t) others.emplace_back(work);
  work();
}

}  // namespace raybundle
