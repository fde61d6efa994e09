// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "raybundle/occupancy/scan.hpp"

namespace raybundle {

/// A scan of whose points none is taken to be less sure than the surest quarter is: bounds that widen with a point's sigma
/// would else let what is hardly known lie on any surface. Fits weigh by the capped sigmas, too.
class CappedScan {
 public:
  explicit CappedScan(const Scan& scan) : scan_(scan), most_sigma_m_(quarter_sigma_m(scan)) {}

  const Scan& scan() const { return scan_; }
  double sigma_m(const ScenePoint& point) const { return std::min(point.sigma_m, most_sigma_m_); }

 private:
  // The sigma of rank floor((n - 1) / 4), without heap: numbers that are not negative have the order of their bits.
  static double quarter_sigma_m(const Scan& scan) {
    const std::size_t below = scan.points.empty() ? 0 : (scan.points.size() - 1) / 4;
    std::uint64_t low = 0, high = std::bit_cast<std::uint64_t>(std::numeric_limits<double>::infinity());
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      const double sigma_m = std::bit_cast<double>(middle);
      const auto count = static_cast<std::size_t>(
          std::ranges::count_if(scan.points, [&](const ScenePoint& point) { return point.sigma_m <= sigma_m; }));
      if (count > below) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    return std::bit_cast<double>(high);
  }

  const Scan& scan_;
  double most_sigma_m_;
};

}  // namespace raybundle
