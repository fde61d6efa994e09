// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/seat.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

inline constexpr int kMostAttributes = 256;

/// Attributes of a situation, without heap.
using Attributes = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostAttributes, 1>;

/// A way to describe a situation. Learnt cases and what is held against them must be described alike: the name goes
/// into the base.
struct AttributeSet {
  std::string_view name;
  int size;
  Attributes (*attributes)(const VehicleLayout& layout, const SeatPose& seat, const Scan& scan);
};

/// For hundreds of points. Profile: horizontal stripes of the longitudinal plane, one around the cushion, two above it
/// and one for heads, each cut along x into boxes; how full each is of what the rays saw of it. Relief: for places on
/// the empty seat, how far before them the rays end. Reach: how many rays end before the dashboard.
extern const AttributeSet kStripes;

/// For thousands of points: the same with less blur.
extern const AttributeSet kBoxes;

/// The set of that name; nullptr when there is none.
const AttributeSet* attribute_set_named(std::string_view name);

}  // namespace raybundle
