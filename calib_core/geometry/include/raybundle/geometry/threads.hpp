// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace raybundle {

/// So many threads that each call loop() once; fewer, down to none, when the system gives no more.
template <typename Loop>
std::vector<std::jthread> start_threads(int count, const Loop& loop) {
  std::vector<std::jthread> threads;
  threads.reserve(static_cast<std::size_t>(std::max(count, 0)));
  try {
    for (int t = 0; t < count; ++t) threads.emplace_back(loop);
  } catch (const std::system_error&) {
    // Whoever calls shares the work out to the threads that there are.
  }
  return threads;
}

/// Calls work(0), ..., work(count - 1), each once, on so many threads; passes the first exception on.
///
/// @param threads  of which the calling one is the first
template <typename Work>
void for_each_index(std::size_t count, int threads, Work&& work) {
  std::atomic<std::size_t> next{0};
  std::mutex guard;
  std::exception_ptr failure;
  const auto loop = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::scoped_lock lock(guard);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  const auto wanted = std::min(count, static_cast<std::size_t>(std::max(threads, 1)));
  std::vector<std::jthread> others = start_threads(static_cast<int>(wanted) - 1, loop);
  loop();
  others.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace raybundle
