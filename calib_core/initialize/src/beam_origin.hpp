// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "beam_lattice.hpp"
#include "beam_lines.hpp"

namespace raybundle {

/// Which beam each line is.
struct BeamOrigin {
  std::vector<int> beam_of_line;  ///< or kUnlabelled, for lines off the lattice or outside of the grid
  std::string reason;             ///< what fixed the origin, in words
  bool guessed = false;           ///< nothing did
};

/// Shifts the lattice into the grid of the problem's laser so that it agrees with the anchor, the brightest and the
/// missing beams. What these leave open is settled by taking the middle, and `reason` says so. A lattice that does not
/// fit into the grid otherwise is turned by a quarter, or as dots whose beams are named say.
///
/// @throws Error(kNotEnoughData) when the lattice has more rows or columns than the grid; Error(kBadInput) when the
///         anchor is not near one line only, or nothing agrees with what is said of the beams
BeamOrigin beam_origin(const LaserScene& scene, const std::vector<BeamHit>& hits, const std::vector<HitLine>& lines,
                       const std::vector<std::optional<LatticePlace>>& places);

}  // namespace raybundle
