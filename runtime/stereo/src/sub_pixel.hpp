// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace raybundle {

/// Where between the neighbours of the best disparity the cost is least [px], from -0.5 to 0.5.
///
/// Two lines of opposite slope through the three costs, or sums of them, as fits costs that count: a parabola would pull
/// towards whole pixels by 0.1 px. What pull is left (0.03 px at most: the curve that prove_stereo prints) is added back.
inline float sub_pixel(int before, int cost, int after) {
  const int low = before - cost;
  const int high = after - cost;
  const int steep = std::max(std::max(low, high), 1);
  const float fitted =
      std::min(std::max(0.5F * static_cast<float>(low - high) / static_cast<float>(steep), -0.5F), 0.5F);
  constexpr float kPull = 0.24F;
  return fitted + kPull * fitted * (1.0F - 2.0F * std::abs(fitted));
}

}  // namespace raybundle
