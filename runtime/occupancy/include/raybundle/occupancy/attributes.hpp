// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/seat.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

inline constexpr int kMostAttributes = 128;

/// Attributes of a situation, without heap.
using Attributes = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostAttributes, 1>;

/// A way to describe a situation. Learnt cases and what is held against them must be described alike: the name goes
/// into the base.
struct AttributeSet {
  std::string_view name;
  int size;
  Attributes (*attributes)(const VehicleLayout& layout, const SeatPose& seat, const Scan& scan);
};

/// For hundreds of points: horizontal stripes of the longitudinal plane, one around the cushion, two above it and one
/// for heads, each cut along x; how full each part is of what the rays saw of it.
extern const AttributeSet kStripes;

/// For thousands of points: two boxes of the seat, one above its cushion and two along its back whose heights follow
/// the occupant, the stripes more finely, and how much of it is flat.
extern const AttributeSet kBoxes;

/// The set of that name; nullptr when there is none.
const AttributeSet* attribute_set_named(std::string_view name);

}  // namespace raybundle
