// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capped_scan.hpp"
#include "raybundle/occupancy/head.hpp"

namespace raybundle {

inline constexpr double kBehind_m = 0.05;  ///< what ends so far behind the head's middle has passed it
inline constexpr double kChin = -0.5;      ///< of the crown's axis: below, necks and collars are taken for heads

/// Fits the ellipsoid of a head from a start within a few centimetres; not found when too few points are on it.
/// Gauss-Newton with Tukey's biweight on distances from the surface, and priors of size, turn and nod;
/// the lower the head is above the seat, the smaller it commonly is.
Head fit_head(const CappedScan& capped, const SeatPose& seat, const Eigen::Vector3d& start, const HeadOptions& options);

}  // namespace raybundle
