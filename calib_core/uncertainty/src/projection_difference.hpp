// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/uncertainty/comparison.hpp"

namespace raybundle {

/// One camera of two calibrations, at one range.
///
/// @param covariance_a, covariance_b  what sigmas come from
ProjectionDifference projection_difference(const RigCamera& a, const Covariance& covariance_a, const RigCamera& b,
                                           const Covariance& covariance_b, double range_m, int columns);

}  // namespace raybundle
