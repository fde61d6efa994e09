// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "raybundle/scene/result.hpp"

namespace raybundle {

/// Adds the seconds of its life to the stage of that name.
class Stopwatch {
 public:
  Stopwatch(std::vector<StageTime>& stages, std::string name) : stages_(stages), name_(std::move(name)) {}

  ~Stopwatch() {
    auto found = std::ranges::find(stages_, name_, &StageTime::name);
    if (found == stages_.end()) found = stages_.insert(found, {name_, 0.0});
    found->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  std::vector<StageTime>& stages_;
  std::string name_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace raybundle
