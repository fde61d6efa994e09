// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/board_picture.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "board_dictionary.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

BoardPicture picture_of_size(double width, double height, const Eigen::Vector2d& origin) {
  return {{width, height}, {}, {}, false, origin, Eigen::Vector2d::UnitX(), Eigen::Vector2d::UnitY()};
}

cv::Mat bits_of(const cv::aruco::Dictionary& dictionary, int id) {
  return cv::aruco::Dictionary::getBitsFromByteList(dictionary.bytesList.row(id), dictionary.markerSize);
}

// The dark cells of a marker, row by row from the top-left: its border and the bits that are 0.
void add_marker(BoardPicture& picture, const cv::Mat& bits, int border_bits, const Eigen::Vector2d& corner,
                double side) {
  const int cells = bits.rows + 2 * border_bits;
  const double cell = side / cells;
  const auto dark = [&](int row, int column) {
    const int i = row - border_bits;
    const int j = column - border_bits;
    return i < 0 || j < 0 || i >= bits.rows || j >= bits.cols || bits.at<unsigned char>(i, j) == 0;
  };
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells;) {
      int end = column;
      while (end < cells && dark(row, end)) ++end;
      if (end > column) {
        picture.rectangles.push_back({corner + Eigen::Vector2d(column, row) * cell, {(end - column) * cell, cell}});
      }
      column = end + 1;
    }
  }
}

// Squares whose (column + row) % 2 is `first` are black.
void add_squares(BoardPicture& picture, int columns, int rows, double side, int first) {
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if ((column + row) % 2 == first) picture.rectangles.push_back({{column * side, row * side}, {side, side}});
    }
  }
}

BoardPicture draw_kind(const Chessboard& board) {
  const double side = board.square_m;
  BoardPicture picture = picture_of_size((board.columns + 1) * side, (board.rows + 1) * side, {side, side});
  add_squares(picture, board.columns + 1, board.rows + 1, side, 0);
  return picture;
}

BoardPicture draw_kind(const Charuco& board) {
  const double side = board.square_m;
  BoardPicture picture = picture_of_size(board.columns * side, board.rows * side, {side, side});
  picture.inverted = board.inverted;
  // The old layout numbered the rows from below, so that with an even number of them the colours change places.
  const int black = board.legacy && board.rows % 2 == 0 ? 1 : 0;
  add_squares(picture, board.columns, board.rows, side, black);
  const auto dictionary = dictionary_named(board.dictionary);
  const double inset = 0.5 * (side - board.marker_m);
  int id = 0;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if ((column + row) % 2 == black) continue;
      const Eigen::Vector2d corner(column * side + inset, row * side + inset);
      add_marker(picture, bits_of(*dictionary, id++), 1, corner, board.marker_m);
    }
  }
  return picture;
}

// y points up in the target frame.
BoardPicture draw_kind(const AprilGrid& board) {
  const double gap = board.spacing * board.tag_m;
  const double step = board.tag_m + gap;
  const double width = board.columns * step + gap;
  const double height = board.rows * step + gap;
  BoardPicture picture = picture_of_size(width, height, {gap, height - gap});
  picture.y_direction = -Eigen::Vector2d::UnitY();
  const auto dictionary = tag_family_named(board.family);
  for (int tag = 0; tag < board.columns * board.rows; ++tag) {
    const Eigen::Vector2d corner(gap + board.column(tag) * step, height - (board.row_from_bottom(tag) + 1) * step);
    cv::Mat bits = bits_of(*dictionary, board.first_tag + tag);
    // Of the AprilTag families, OpenCV holds the published codes upside down.
    if (!board.family.starts_with("DICT_")) cv::flip(bits, bits, -1);
    add_marker(picture, bits, board.border_bits, corner, board.tag_m);
  }
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column) {
      picture.rectangles.push_back({{column * step, row * step}, {gap, gap}});
    }
  }
  return picture;
}

BoardPicture discs_at_points(const Board& board, double nearest_m) {
  const double radius = 0.25 * nearest_m;
  const Target target = target_of(board);
  Eigen::Vector3d far = Eigen::Vector3d::Zero();
  for (const TargetPoint& point : target.points) far = far.cwiseMax(point.x_in_target);
  BoardPicture picture = picture_of_size(far.x() + 2 * radius, far.y() + 2 * radius, {radius, radius});
  for (const TargetPoint& point : target.points) {
    picture.discs.push_back({picture.picture_from_target(point.x_in_target), radius});
  }
  return picture;
}

BoardPicture draw_kind(const Circles& board) { return discs_at_points(board, board.spacing_m); }

BoardPicture draw_kind(const AsymmetricCircles& board) { return discs_at_points(board, board.nearest_m()); }

BoardPicture draw_kind(const PointSet& board) {
  throw Error(ErrorKind::kBadInput, "a list of points has no print that could be drawn", board.file);
}

}  // namespace

BoardPicture picture_of(const Board& board) {
  check(board);
  return std::visit([](const auto& kind) { return draw_kind(kind); }, board);
}

}  // namespace raybundle
