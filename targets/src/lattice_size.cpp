// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lattice_size.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace raybundle {
namespace {

std::string size_text(int columns, int rows) { return fmt::format("{}x{}", columns, rows); }

double filled_part(const Lattice& lattice, const LatticeExtent& extent) {
  return static_cast<double>(lattice.size()) / (extent.width() * extent.height());
}

/// The lattice's sparsest border line, as part of a full one: things beside a board make sparse lines.
double sparsest_border(const Lattice& lattice, const LatticeExtent& extent) {
  int left = 0, right = 0, top = 0, bottom = 0;
  for (const auto& [place, saddle] : lattice) {
    left += place.first == extent.low_x;
    right += place.first == extent.high_x;
    top += place.second == extent.low_y;
    bottom += place.second == extent.high_y;
  }
  return std::min(std::min(left, right) / static_cast<double>(extent.height()),
                  std::min(top, bottom) / static_cast<double>(extent.width()));
}

/// The board with one more column, row or both that a lattice fills from side to side.
std::optional<Chessboard> larger_board(const Lattice& lattice, const Chessboard& board) {
  constexpr double kLeastBorder = 0.5;
  const LatticeExtent extent = extent_of(lattice);
  if (lattice.empty() || sparsest_border(lattice, extent) < kLeastBorder) return std::nullopt;
  for (const auto& [more_columns, more_rows] : {std::pair(1, 1), std::pair(1, 0), std::pair(0, 1)}) {
    Chessboard larger = board;
    larger.columns += more_columns;
    larger.rows += more_rows;
    if (std::minmax(larger.columns, larger.rows) == std::minmax(extent.width(), extent.height())) return larger;
  }
  return std::nullopt;
}

}  // namespace

Detection detection_on_lattice(const Lattice& lattice, const LatticeBorders& closed, const Chessboard& board) {
  if (const auto placed = placed_on_board(lattice, closed, board)) return {*placed, {}, {}};
  const auto larger = larger_board(lattice, board);
  if (!larger) return {};
  const auto placed = placed_on_board(lattice, closed, *larger);
  if (!placed) return {};
  Detection part;
  for (Observation seen : *placed) {
    const int column = seen.point_id % larger->columns;
    const int row = seen.point_id / larger->columns;
    if (column >= board.columns || row >= board.rows) continue;
    seen.point_id = row * board.columns + column;
    part.observations.push_back(seen);
  }
  const std::string asked = size_text(board.columns, board.rows);
  const std::string shown = size_text(larger->columns, larger->rows);
  part.hint = fmt::format(
      "the board shows {} inner corners, {} were asked for: using the {} of them next to corner 0; chessboard:{} would "
      "use all",
      shown, asked, asked, shown);
  return part;
}

Detection unplaced_lattice(const Lattice& lattice, const LatticeBorders& closed, const Chessboard& board) {
  constexpr std::size_t kFewest = 12;
  constexpr int kNarrowest = 3;
  constexpr double kLeastFilled = 0.9;
  const LatticeExtent extent = extent_of(lattice);
  if (lattice.size() < kFewest || std::min(extent.width(), extent.height()) < kNarrowest ||
      filled_part(lattice, extent) < kLeastFilled) {
    return {};
  }
  const auto [low, high] = std::minmax({extent.width(), extent.height()});
  const auto [board_low, board_high] = std::minmax({board.columns, board.rows});
  const std::string asked = size_text(board.columns, board.rows);
  const std::string seen = board.columns < board.rows ? size_text(low, high) : size_text(high, low);
  const bool all_closed = closed.low_x && closed.high_x && closed.low_y && closed.high_y;
  const bool fits = low <= board_low && high <= board_high;
  if (all_closed || !fits) {
    if (low == board_low && high == board_high) return {};
    return {{},
            fmt::format("a chessboard of {}{} inner corners is in the image, not {}", all_closed ? "" : "at least ",
                        seen, asked),
            seen};
  }
  const bool as_squares = low == board_low - 1 && high == board_high - 1;  // how the mistake would look that is usual
  const std::string counted =
      as_squares ? fmt::format("; did you count squares? chessboard:{}:SQUARE would fit", seen) : "";
  return {{},
          fmt::format("{} inner corners of a chessboard are in the image, but not where on the {} board they lie: part "
                      "of the board is out of sight, or the board is not {}{}",
                      seen, asked, asked, counted),
          {}};
}

}  // namespace raybundle
