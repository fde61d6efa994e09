// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "board_dictionary.hpp"
#include "circle_lattice.hpp"

#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board_kind.hpp"

namespace raybundle {
namespace {

constexpr int kMostPoints = 100'000;  // far above any printed board; keeps a mistyped count from filling the memory

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorKind::kBadInput, message); }

void check_grid(const std::string& what, int columns, int rows, int fewest) {
  if (columns < fewest || rows < fewest) {
    refuse(fmt::format("columns and rows count {} and must be at least {}, not {}x{}", what, fewest, columns, rows));
  }
  if (static_cast<long long>(columns) * rows > kMostPoints) {
    refuse(fmt::format("columns x rows = {}x{} is more than any board has (at most {})", columns, rows, kMostPoints));
  }
}

void check_size(const char* field, double size_m) {
  if (!(size_m > 0.0) || !std::isfinite(size_m)) {
    refuse(fmt::format("{} must be a positive length in metres, not {}", field, size_m));
  }
}

void check_board(const Chessboard& board) {
  check_grid("inner corners", board.columns, board.rows, 2);
  check_size("square_m", board.square_m);
}

void check_board(const Charuco& board) {
  check_grid("squares", board.columns, board.rows, 3);
  check_size("square_m", board.square_m);
  check_size("marker_m", board.marker_m);
  if (board.marker_m >= board.square_m) {
    refuse(fmt::format("marker_m = {} must be smaller than square_m = {}: the marker stands inside its square",
                       board.marker_m, board.square_m));
  }
  const int markers = dictionary_named(board.dictionary)->bytesList.rows;
  const int needed = board.columns * board.rows / 2;
  if (needed > markers) {
    refuse(fmt::format("a {}x{} ChArUco board needs {} markers, but dictionary {} has {}", board.columns, board.rows,
                       needed, board.dictionary, markers));
  }
}

void check_board(const AprilGrid& board) {
  check_grid("tags", board.columns, board.rows, 1);
  check_size("tag_m", board.tag_m);
  if (!(board.spacing > 0.0) || !(board.spacing < 10.0)) {
    refuse(fmt::format("spacing is the gap between tags over the tag's size, 0.3 for Kalibr's boards, not {}",
                       board.spacing));
  }
  if (board.border_bits != 1 && board.border_bits != 2) {
    refuse(fmt::format("border_bits must be 2 (Kalibr) or 1 (AprilTag), not {}", board.border_bits));
  }
  const int tags = tag_family_named(board.family)->bytesList.rows;
  if (board.first_tag < 0 || board.columns * board.rows > tags - board.first_tag) {
    refuse(fmt::format("a {}x{} grid from first_tag {} on needs {} tags, but family {} has codes 0 to {}",
                       board.columns, board.rows, board.first_tag, board.columns * board.rows, board.family, tags - 1));
  }
}

void check_circles(int columns, int rows) {
  check_grid("circles", columns, rows, 2);
  const auto circles = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (circles > kMostEllipses) {
    refuse(
        fmt::format("a grid of {}x{} circles is too large: at most {} are told apart", columns, rows, kMostEllipses));
  }
}

void check_board(const Circles& board) {
  check_circles(board.columns, board.rows);
  check_size("spacing_m", board.spacing_m);
}

void check_board(const AsymmetricCircles& board) {
  check_circles(board.columns, board.rows);
  check_size("spacing_m", board.spacing_m);
  if (board.row_step_m != 0.0) check_size("row_step_m", board.row_step_m);
}

void check_board(const PointSet& board) {
  if (board.points.size() < 4) {
    refuse(fmt::format("a board needs at least 4 points, \"{}\" has {}", board.file, board.points.size()));
  }
  for (const TargetPoint& point : board.points) {
    if (point.id < 0) refuse(fmt::format("point_id {} is negative", point.id));
    if (!point.x_in_target.allFinite()) refuse(fmt::format("point {} is not finite", point.id));
  }
  std::vector<int> ids;
  for (const TargetPoint& point : board.points) ids.push_back(point.id);
  std::ranges::sort(ids);
  const auto twice = std::ranges::adjacent_find(ids);
  if (twice != ids.end()) refuse(fmt::format("point_id {} stands twice in the point list", *twice));
}

// Corner (0, 0) at the origin, x along the rows, y down the columns.
std::vector<TargetPoint> grid(int columns, int rows, double step_m) {
  std::vector<TargetPoint> points;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      points.push_back({row * columns + column, {column * step_m, row * step_m, 0.0}});
    }
  }
  return points;
}

std::vector<TargetPoint> points_of(const Chessboard& board) { return grid(board.columns, board.rows, board.square_m); }

std::vector<TargetPoint> points_of(const Charuco& board) {
  return grid(board.columns - 1, board.rows - 1, board.square_m);
}

std::vector<TargetPoint> points_of(const Circles& board) { return grid(board.columns, board.rows, board.spacing_m); }

std::vector<TargetPoint> points_of(const AsymmetricCircles& board) {
  const int shift = board.first_row_shifted ? 1 : 0;
  std::vector<TargetPoint> points;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const double x = (2 * column + (row + shift) % 2) * board.spacing_m;
      points.push_back({row * board.columns + column, {x, row * board.between_rows_m(), 0.0}});
    }
  }
  return points;
}

std::vector<TargetPoint> points_of(const AprilGrid& board) {
  const double step_m = board.tag_m * (1.0 + board.spacing);
  constexpr std::array<std::array<int, 2>, 4> kCorners{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  std::vector<TargetPoint> points;
  for (int tag = 0; tag < board.columns * board.rows; ++tag) {
    for (int corner = 0; corner < 4; ++corner) {
      const double x = board.column(tag) * step_m + kCorners[corner][0] * board.tag_m;
      const double y = board.row_from_bottom(tag) * step_m + kCorners[corner][1] * board.tag_m;
      points.push_back({4 * tag + corner, {x, y, 0.0}});
    }
  }
  return points;
}

std::vector<TargetPoint> points_of(const PointSet& board) {
  std::vector<TargetPoint> points = board.points;
  std::ranges::sort(points, {}, &TargetPoint::id);
  return points;
}

// Where the grid's cell (column, row) comes to lie when the print is turned by 180°.
TargetSymmetry half_turn(int columns, int rows) {
  TargetSymmetry turned;
  for (int id = 0; id < columns * rows; ++id) turned.ids.push_back(columns * rows - 1 - id);
  return turned;
}

// By 90° as well: (column, row) -> (n - 1 - row, column), and back.
std::array<TargetSymmetry, 2> quarter_turns(int n) {
  std::array<TargetSymmetry, 2> turned;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      turned[0].ids.push_back(column * n + (n - 1 - row));
      turned[1].ids.push_back((n - 1 - column) * n + row);
    }
  }
  return turned;
}

// Square (i, j) of (columns + 1) x (rows + 1) is black when i + j is even. Turned by 180° it lies at
// (columns - i, rows - j): the same colour when columns + rows is even. Turned by 90° on a square board, at
// (columns - j, i): the same colour when columns is even.
std::vector<TargetSymmetry> symmetries_of(const Chessboard& board) {
  std::vector<TargetSymmetry> symmetries;
  if ((board.columns + board.rows) % 2 == 0) symmetries.push_back(half_turn(board.columns, board.rows));
  if (board.columns == board.rows && board.columns % 2 == 0) {
    for (TargetSymmetry& turned : quarter_turns(board.columns)) symmetries.push_back(std::move(turned));
  }
  return symmetries;
}

std::vector<TargetSymmetry> symmetries_of(const Circles& board) {
  std::vector<TargetSymmetry> symmetries{half_turn(board.columns, board.rows)};
  if (board.columns == board.rows) {
    for (TargetSymmetry& turned : quarter_turns(board.columns)) symmetries.push_back(std::move(turned));
  }
  return symmetries;
}

// With an odd number of rows the shifted rows are the inner ones: turned by 180° they would stick out on the left.
// Turned by 90°, columns of circles never stand where rows did, as the shift changes sides.
std::vector<TargetSymmetry> symmetries_of(const AsymmetricCircles& board) {
  if (board.rows % 2 != 0) return {};
  return {half_turn(board.columns, board.rows)};
}

std::vector<TargetSymmetry> symmetries_of(const Charuco&) { return {}; }    // the markers tell the sides apart
std::vector<TargetSymmetry> symmetries_of(const AprilGrid&) { return {}; }  // so do the tags
std::vector<TargetSymmetry> symmetries_of(const PointSet&) { return {}; }   // nothing is known of its print

}  // namespace

void check(const Board& board) {
  try {
    std::visit([](const auto& kind) { check_board(kind); }, board);
  } catch (const Error& error) {
    throw Error(error.kind(), error.what(), board_kind_of(board).name);
  }
}

Target target_of(const Board& board) {
  check(board);
  return std::visit([](const auto& kind) { return Target{"board", points_of(kind), symmetries_of(kind)}; }, board);
}

}  // namespace raybundle
