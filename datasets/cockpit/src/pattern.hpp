// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace raybundle {

/// A pattern without period: sums of smooth noise on ever coarser lattices. Mean 0, standard deviation about 1.
///
/// @param place    [m]
/// @param grain_m  distance of the finest lattice's points; four lattices, each twice as coarse as the one before
double pattern_at(const Eigen::Vector3f& place, double grain_m, std::uint32_t seed);

}  // namespace raybundle
