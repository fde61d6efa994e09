// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/result.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {

double LaserSummary::drag_sigmas() const {
  double largest = 0.0;
  for (const DraggedParameter& parameter : parameters) {
    if (!(parameter.sigma_without > 0.0)) continue;
    largest = std::max(largest, std::abs(parameter.with - parameter.without) / parameter.sigma_without);
  }
  return largest;
}

}  // namespace raybundle
