// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace raybundle::apps {

/// Points of a pair in a car that are looked at: more cost time and tell no more of things as large as heads.
inline constexpr int kMostCabinPoints = 20000;

/// Every how many pixels, each way, one is taken so that at most about `most` of the matched ones remain.
inline int thinning_step(int matched, int most) {
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(matched) / most))));
}

}  // namespace raybundle::apps
