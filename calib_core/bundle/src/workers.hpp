// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace raybundle {

/// Threads that live as long as the solve and sleep between its loops, unless these follow each other closely.
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
  void work();
  void wait_for_loops();

  const std::function<void(int)>* function_ = nullptr;
  int count_ = 0;
  int batch_ = 1;
  std::atomic<int> next_{0};
  std::atomic<int> loops_{0};  ///< started so far; negative: the end
  std::atomic<int> busy_{0};
  std::vector<std::jthread> others_;
};

}  // namespace raybundle
