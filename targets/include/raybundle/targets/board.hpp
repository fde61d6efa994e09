// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "raybundle/scene/target.hpp"

namespace raybundle {

/// Chessboard; columns and rows count inner corners. id = row * columns + column, x = column * square, y = row *
/// square.
struct Chessboard {
  int columns = 0;
  int rows = 0;
  double square_m = 0.0;
};

/// ChArUco board; columns and rows count squares; points are the inner corners, id and axes as on a chessboard.
struct Charuco {
  int columns = 0;
  int rows = 0;
  double square_m = 0.0;
  double marker_m = 0.0;
  std::string dictionary;  ///< DICT_4X4_1000, ...
  bool legacy = false;     ///< the layout before OpenCV 4.6: matters for boards with an even number of rows
  bool inverted = false;   ///< white on black
};

/// Grid of AprilTags as Kalibr's: tags row by row from the bottom-left, or as OpenCV's GridBoard from the top-left;
/// x right, y up, origin at the outer corner of the bottom-left tag; point id = 4 * tag + corner, corners anticlockwise
/// from the tag's bottom-left. Codes start at first_tag.
struct AprilGrid {
  int columns = 0;
  int rows = 0;
  double tag_m = 0.0;            ///< outer edge of the black border
  double spacing = 0.0;          ///< gap between tags over tag_m
  std::string family = "36h11";  ///< 36h11, 25h9, 16h5, or a dictionary of OpenCV's, DICT_4X4_50, ...
  int border_bits = 2;           ///< Kalibr: 2; AprilTag itself: 1
  int first_tag = 0;             ///< the lowest code, so that several boards can be told apart
  bool top_down = false;         ///< codes count from the top-left tag, row by row down

  int column(int tag) const { return tag % columns; }
  int row_from_bottom(int tag) const { return top_down ? rows - 1 - tag / columns : tag / columns; }
};

/// Grid of circles; id = row * columns + column.
struct Circles {
  int columns = 0;
  int rows = 0;
  double spacing_m = 0.0;
};

/// OpenCV's asymmetric grid: `columns` circles in each of `rows` rows, odd rows shifted by half a step;
/// x = (2 * column + row % 2) * spacing, y = row * row_step. Its mirror image is another board: first_row_shifted.
struct AsymmetricCircles {
  int columns = 0;
  int rows = 0;
  double spacing_m = 0.0;
  double row_step_m = 0.0;         ///< 0: as spacing_m; a hexagonal grid has sqrt(3) * spacing_m
  bool first_row_shifted = false;  ///< the even rows are shifted instead: x = (2 * column + (row + 1) % 2) * spacing

  double between_rows_m() const { return row_step_m > 0.0 ? row_step_m : spacing_m; }
  /// From a circle to the nearest other one: in its row, in the next, or in the one after that.
  double nearest_m() const {
    return std::min(2.0 * std::min(spacing_m, between_rows_m()), std::hypot(spacing_m, between_rows_m()));
  }
};

/// Any rigid set of points, for observations that others made; it cannot be detected or drawn.
struct PointSet {
  std::string file;
  std::vector<TargetPoint> points;
};

/// The one list of board kinds.
using Board = std::variant<Chessboard, Charuco, AprilGrid, Circles, AsymmetricCircles, PointSet>;

/// The board's points, with the symmetries under which its print looks the same. Calls check().
Target target_of(const Board& board);

/// Throws Error(kBadInput) naming the field that no board can have: counts below the smallest grid, sizes that are not
/// positive, a marker larger than its square, an unknown dictionary or family, more tags than the family has.
void check(const Board& board);

/// The board that a word on the command line names: chessboard:9x6:25mm,
/// charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000:legacy, aprilgrid:6x6:88mm:0.3:36h11:1bit, ... Lengths carry their unit:
/// mm, cm, m, in. Required fields stand in their order, optional ones behind them in any order. board_kinds() has the
/// forms.
///
/// @throws Error(kBadInput) in one sentence that shows the right form; Error(kIo) when a point file cannot be read
Board board_from_word(const std::string& word);

/// The word that gives back this board bit by bit: what is printed below a drawn board.
std::string word_of(const Board& board);

}  // namespace raybundle
