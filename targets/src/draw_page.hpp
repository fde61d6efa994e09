// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "raybundle/targets/board_picture.hpp"
#include "raybundle/targets/draw.hpp"

namespace raybundle {

constexpr double kRulerLength = 0.100;  // [m]
constexpr double kStripGap = 0.004;     // [m] white between the board and the ruler
constexpr double kRulerHeight = 0.004;  // [m]
constexpr double kTextHeight = 0.0025;  // [m] of capital letters in the caption
constexpr double kStripHeight = kStripGap + kRulerHeight + 2.0 * kTextHeight;

/// Where things stand on a page, x right, y down from its top-left [m].
struct Page {
  std::string paper;
  Eigen::Vector2d size;
  Eigen::Vector2d board;                 ///< top-left of the picture
  std::optional<Eigen::Vector2d> strip;  ///< top-left of the ruler, when there is one
};

/// The page of a board: on paper, with ruler.
Page page_of(const Board& board, const BoardPicture& picture, const DrawOptions& options);

/// Only the board and its margin.
Page bare_page_of(const BoardPicture& picture, double margin_m);

}  // namespace raybundle
