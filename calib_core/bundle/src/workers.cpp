// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "workers.hpp"

#include <algorithm>

#include "raybundle/geometry/threads.hpp"

namespace raybundle {
namespace {

// The next loop of a solve, or the end of one, is mostly nearer than a thread would take to fall asleep and be woken.
void wait_for_change(const std::atomic<int>& value, int seen) {
  constexpr int kLooks = 100;  // for some tens of microseconds
  for (int look = 0; look < kLooks && value == seen; ++look) std::this_thread::yield();
  value.wait(seen);
}

}  // namespace

Workers::Workers(int threads) : others_(start_threads(threads - 1, [this] { wait_for_loops(); })) {}

Workers::~Workers() {
  loops_ = -1;
  loops_.notify_all();
}

void Workers::for_each(int count, const std::function<void(int)>& function) {
  function_ = &function;
  // Some calls at a time, since one may be shorter than what it costs to hand it out; but all threads shall end
  // together.
  left_ = {count, std::clamp(count / (16 * (1 + static_cast<int>(others_.size()))), 1, 8)};
  if (!others_.empty()) {
    ++loops_;
    loops_.notify_all();
  }
  work();
  for (int helping = helping_; helping > 0; helping = helping_) wait_for_change(helping_, helping);
}

void Workers::work() {
  for (Left left = left_; left.count > 0;) {
    const int begin = std::max(0, left.count - left.batch);
    if (!left_.compare_exchange_weak(left, {begin, left.batch})) continue;
    for (int i = begin; i < left.count; ++i) (*function_)(i);
    left = left_;
  }
}

void Workers::wait_for_loops() {
  for (int seen = 0;;) {
    wait_for_change(loops_, seen);
    seen = loops_;
    if (seen < 0) return;
    ++helping_;
    work();
    if (--helping_ == 0) helping_.notify_one();
  }
}

}  // namespace raybundle
