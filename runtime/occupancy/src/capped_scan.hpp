// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/occupancy/scan.hpp"

namespace raybundle {

/// A scan's points, none of them less sure than the surest quarter is: bounds that widen with a point's sigma would else let
/// what is hardly known lie on any surface. Fits weigh by the capped sigmas, too.
class CappedScan {
 public:
  explicit CappedScan(const Scan& scan) : scan_(scan), points_(scan.points.begin(), scan.points.end()) {
    std::vector<double> sigmas_m;
    for (const ScenePoint& point : points_) sigmas_m.push_back(point.sigma_m);
    const double sure_m = quantile(sigmas_m, 0.25);
    for (ScenePoint& point : points_) point.sigma_m = std::min(point.sigma_m, sure_m);
    scan_.points = points_;
  }
  CappedScan(const CappedScan&) = delete;
  CappedScan& operator=(const CappedScan&) = delete;

  const Scan& scan() const { return scan_; }

 private:
  Scan scan_;
  std::vector<ScenePoint> points_;
};

}  // namespace raybundle
