// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "lattice.hpp"
#include "lattice_place.hpp"
#include "raybundle/targets/board.hpp"
#include "raybundle/targets/detect.hpp"

namespace raybundle {

/// The corners of a board on a lattice; of a board that shows one column or row more, or both, the part next to its
/// corner 0, with a hint that says so. Empty when the lattice does not fit, or fits in several ways.
Detection detection_on_lattice(const Lattice& lattice, const LatticeBorders& closed, const Chessboard& board);

/// Says which size a lattice has that is not placed on the board asked for: the usual cause is a wrong board size. No
/// hint for a lattice so small or so full of gaps that it may not be a board at all. The sentence holds no number but
/// the two sizes, so that it is the same for all images of one board.
Detection unplaced_lattice(const Lattice& lattice, const LatticeBorders& closed, const Chessboard& board);

}  // namespace raybundle
