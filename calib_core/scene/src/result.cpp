// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/result.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {

double DraggedParameter::moved_sigmas() const {
  return sigma_without > 0.0 ? std::abs(with - without) / sigma_without : 0.0;
}

double drag_sigmas(const std::vector<DraggedParameter>& parameters) {
  double largest = 0.0;
  for (const DraggedParameter& parameter : parameters) largest = std::max(largest, parameter.moved_sigmas());
  return largest;
}

}  // namespace raybundle
