// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace raybundle {

/// Threads that live as long as the solve and sleep between its loops, unless these follow each other closely. A loop
/// waits for nobody who has not begun to help, as a thread that the machine has no processor for.
class Workers {
 public:
  /// @param threads  of which the calling one is the first; fewer, with the same results, when the system gives no more
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Calls function(i) for i in [0, count), in any order, on all threads. The calls must not depend on each other and
  /// must not throw.
  void for_each(int count, const std::function<void(int)>& function);

 private:
  // What is left of a loop: the calls below `count`, of which each thread takes `batch` at a time.
  struct Left {
    int count = 0;
    int batch = 1;
  };

  void work();
  void wait_for_loops();

  const std::function<void(int)>* function_ = nullptr;  // read by those who have taken a part of its loop
  std::atomic<Left> left_{};
  static_assert(std::atomic<Left>::is_always_lock_free);
  std::atomic<int> helping_{0};  // threads that may have taken a part
  std::atomic<int> loops_{0};    // started so far; negative: the end
  std::vector<std::jthread> others_;
};

}  // namespace raybundle
