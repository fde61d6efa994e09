// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/occupancy/scan.hpp"

namespace raybundle {

/// A box whose sides are parallel to the vehicle's y axis and turned about it: seats recline.
struct Box {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< [m] in the vehicle frame
  double pitch_rad = 0.0;                            ///< the box's x axis rises by it against the vehicle's
  Eigen::Vector3d low = Eigen::Vector3d::Zero();     ///< [m] corners in the box's own axes, from its origin
  Eigen::Vector3d high = Eigen::Vector3d::Zero();

  Eigen::Vector3d x_in_box(const Eigen::Vector3d& x_in_vehicle) const;
  bool contains(const Eigen::Vector3d& x_in_vehicle) const;
};

/// What rays tell of a box. A ray that ends before the box tells nothing: occlusion is not emptiness.
struct BoxCount {
  int hits = 0;     ///< rays that end in it
  int passed = 0;   ///< that cross it and end behind
  int blocked = 0;  ///< that would cross it but end before

  BoxCount& operator+=(const BoxCount& other) {
    hits += other.hits;
    passed += other.passed;
    blocked += other.blocked;
    return *this;
  }

  /// Share of the rays that saw into the box and ended there, drawn to `prior` as if `weight` more rays had seen it: a
  /// box that nothing saw has the prior.
  double filled(double prior, double weight) const { return (hits + prior * weight) / (hits + passed + weight); }
  /// Share of the rays towards the box that saw into it; 1 when there are none.
  double visible() const {
    const int all = hits + passed + blocked;
    return all == 0 ? 1.0 : static_cast<double>(hits + passed) / all;
  }
};

/// Counts all rays of a scan, or one of so many.
BoxCount count_rays(const Box& box, const Scan& scan, int every = 1);

}  // namespace raybundle
