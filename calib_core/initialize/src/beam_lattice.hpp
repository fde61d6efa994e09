// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "raybundle/geometry/line.hpp"

namespace raybundle {

/// Place of a line in the lattice of directions; the origin is arbitrary.
struct LatticePlace {
  int row = 0;
  int column = 0;
  friend bool operator==(LatticePlace, LatticePlace) = default;
};

/// Numbers lines by the lattice that their directions form, grown from its middle by steps that may change slowly.
/// Columns count along the x axis of the frame, rows along its y axis, as near as the lattice's own steps come to it.
///
/// @return  aligned with the lines; empty for those that the lattice does not reach or that share a place with a line
///          of more weight
std::vector<std::optional<LatticePlace>> lattice_places(const std::vector<Line3>& lines,
                                                        const std::vector<double>& weights);

}  // namespace raybundle
