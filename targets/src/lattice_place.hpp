// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "lattice.hpp"
#include "raybundle/scene/observation.hpp"
#include "raybundle/targets/board.hpp"

namespace raybundle {

/// Which sides of a lattice end at the board's border, so that no corner can be beyond them.
struct LatticeBorders {
  bool low_x = false, high_x = false, low_y = false, high_y = false;
};

/// A side is closed when the row of squares beyond its last corners is followed by plain margin.
LatticeBorders closed_sides(const cv::Mat& gray, const Lattice& lattice);

/// Cuts sparse lines off a lattice that is larger than the board: corners of something beside it.
void trim_lattice(Lattice& lattice, const Chessboard& board);

/// Cuts lines of few corners off where the lattice without them ends at the board's border: what stands on the margin, or
/// beyond it, is no corner, and would leave a board that is seen in part at a wrong place.
void drop_lines_on_margin(const cv::Mat& gray, Lattice& lattice);

/// Ids of a lattice's corners on a board; nothing when it does not fit or fits in several ways that differ by more than
/// a symmetry of the print.
std::optional<std::vector<Observation>> placed_on_board(const Lattice& lattice, const LatticeBorders& closed,
                                                        const Chessboard& board);

}  // namespace raybundle
