// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace raybundle::apps {

/// Calls work(0), ..., work(count - 1), each once, on so many threads; passes the first exception on.
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
  std::vector<std::jthread> workers;
  for (int t = 1; t < threads; ++t) workers.emplace_back(loop);
  loop();
  workers.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace raybundle::apps
