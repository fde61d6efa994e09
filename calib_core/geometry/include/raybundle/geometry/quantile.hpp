// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace raybundle {

/// The value below which the given share of the values lies: the one of rank floor(share (n - 1)), never a mean of two,
/// so that it does not depend on the order and is one of the values. Reorders them. Infinite for no values.
inline double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return std::numeric_limits<double>::infinity();
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

inline constexpr double kNormalMedian = 0.6744897501960817;  // of the size of a standard normal number
inline constexpr double kRayleighMedian =
    1.1774100225154747;  // sqrt(2 ln 2): of the length of a standard normal 2-vector

/// Half of the values lie below: quantile(values, 0.5).
inline double median(std::vector<double>& values) { return quantile(values, 0.5); }

}  // namespace raybundle
