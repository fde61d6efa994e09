// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lattice_place.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace raybundle {
namespace {

std::optional<double> grey_within(const cv::Mat& gray, const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(std::lround(pixel.x()));
  const int y = static_cast<int>(std::lround(pixel.y()));
  if (x < 0 || y < 0 || x >= gray.cols || y >= gray.rows) return std::nullopt;
  return gray.at<uchar>(y, x);
}

/// A side of a lattice: `along` runs along it, `out` leaves the lattice.
struct Side {
  LatticePlace along, out;
};
constexpr Side kLeft{{0, 1}, {-1, 0}}, kRight{{0, 1}, {1, 0}}, kTop{{1, 0}, {0, -1}}, kBottom{{1, 0}, {0, 1}};

/// The outermost places of a side that are taken.
std::vector<LatticePlace> places_along(const Lattice& lattice, const Side& side) {
  const LatticeExtent extent = extent_of(lattice);
  const bool is_column = side.out.first != 0;
  const int line = is_column ? (side.out.first < 0 ? extent.low_x : extent.high_x)
                             : (side.out.second < 0 ? extent.low_y : extent.high_y);
  std::vector<LatticePlace> places;
  for (const auto& [place, saddle] : lattice) {
    if ((is_column ? place.first : place.second) == line) places.push_back(place);
  }
  return places;
}

/// Looks beyond one side, from pairs of neighbouring corners there: the squares' colours alternate on board, not on the
/// margin.
///
/// @param times  that the places which show margin must outnumber those which show more board
bool side_is_closed(const cv::Mat& gray, const Lattice& lattice, const Side& side, int times = 2) {
  const auto& [along, out] = side;
  int margins = 0, boards = 0;
  constexpr double kBeyond = 1.15;  // margins are narrow; nearer, the edge of a square is blurred
  const auto saddle_at = [&](LatticePlace at) -> const Saddle* {
    const auto found = lattice.find(at);
    return found == lattice.end() ? nullptr : &found->second;
  };
  for (const LatticePlace& place : places_along(lattice, side)) {
    // Between two corners, and between those that lie `steps` further in.
    const auto middle_of = [&](int steps) -> std::optional<Eigen::Vector2d> {
      const LatticePlace in{place.first - steps * out.first, place.second - steps * out.second};
      const Saddle *a = saddle_at(in), *b = saddle_at({in.first + along.first, in.second + along.second});
      return a && b ? std::optional<Eigen::Vector2d>(0.5 * (a->pixel + b->pixel)) : std::nullopt;
    };
    const auto middle = middle_of(0), in = middle_of(1), further_in = middle_of(2);
    if (!middle || !in) continue;
    const Saddle &a = *saddle_at(place), &b = *saddle_at({place.first + along.first, place.second + along.second});
    // Towards the rim of a fisheye squares become narrower, one after the other.
    const Eigen::Vector2d last = *middle - *in, before = further_in ? Eigen::Vector2d(*in - *further_in) : last;
    const Eigen::Vector2d step = std::clamp(2.0 - before.norm() / last.norm(), 0.5, 1.5) * last;
    const double contrast = std::min(a.contrast, b.contrast);
    // The square that touches the side, and the one beyond it, or the margin.
    const auto inner = grey_within(gray, *middle + 0.5 * step);
    const auto outer = grey_within(gray, *middle + kBeyond * step);
    if (!inner || !outer) continue;
    const bool even = (place.first + place.second) % 2 == 0;
    const int quadrant = (along.first + out.first) * (along.second + out.second);
    const bool inner_is_bright = (quadrant > 0) == even;
    if (inner_is_bright) {
      // Beyond a bright square comes a dark one, or more margin.
      (*inner - *outer > 0.4 * contrast ? boards : margins) += 1;
    } else {
      // Beyond a dark square comes something bright either way: tells that the square ends here.
      if (*outer - *inner < 0.3 * contrast) boards += 1;
    }
  }
  return margins >= 2 && margins > times * boards;
}

/// One way to lay the lattice on the board: quarter turns, then a shift.
struct Placement {
  int quarters = 0;
  int shift_column = 0, shift_row = 0;

  LatticePlace on_board(LatticePlace place) const {
    const auto [x, y] = place;
    switch (quarters) {
      case 0:
        return {x + shift_column, y + shift_row};
      case 1:
        return {y + shift_column, -x + shift_row};
      case 2:
        return {-x + shift_column, -y + shift_row};
      default:
        return {-y + shift_column, x + shift_row};
    }
  }
};

bool on_board(LatticePlace at, const Chessboard& board) {
  return at.first >= 0 && at.second >= 0 && at.first < board.columns && at.second < board.rows;
}

/// The square outside of board corner (0, 0) is dark under this placement.
bool starts_dark(const Placement& placement) {
  // Even places have a bright square towards +x +y. Board place (0, 0) is lattice place p: a half turn keeps the
  // diagonal pair of squares, a quarter turn takes the other pair.
  const LatticePlace origin = placement.on_board({0, 0});
  const bool even = (origin.first + origin.second) % 2 == 0;  // a turn keeps the parity of a difference
  return placement.quarters % 2 == 0 ? !even : even;
}

std::vector<Placement> placements_of(const LatticeExtent& extent, const LatticeBorders& closed,
                                     const Chessboard& board) {
  std::vector<Placement> fitting;
  for (int quarters = 0; quarters < 4; ++quarters) {
    const Placement turned{quarters, 0, 0};
    const LatticePlace a = turned.on_board({extent.low_x, extent.low_y});
    const LatticePlace b = turned.on_board({extent.high_x, extent.high_y});
    const int low_column = std::min(a.first, b.first), high_column = std::max(a.first, b.first);
    const int low_row = std::min(a.second, b.second), high_row = std::max(a.second, b.second);
    // Closed sides, turned with the lattice: left, top, right, bottom of the board.
    const std::array<bool, 4> sides{closed.low_x, closed.low_y, closed.high_x, closed.high_y};
    const std::array<bool, 4> of_board = [&]() -> std::array<bool, 4> {
      switch (quarters) {
        case 0:
          return sides;
        case 1:
          return {sides[1], sides[2], sides[3], sides[0]};
        case 2:
          return {sides[2], sides[3], sides[0], sides[1]};
        default:
          return {sides[3], sides[0], sides[1], sides[2]};
      }
    }();
    for (int left = 0; left + high_column - low_column < board.columns; ++left) {
      for (int top = 0; top + high_row - low_row < board.rows; ++top) {
        const int right = left + high_column - low_column;
        const int bottom = top + high_row - low_row;
        if (of_board[0] && left != 0) continue;
        if (of_board[1] && top != 0) continue;
        if (of_board[2] && right != board.columns - 1) continue;
        if (of_board[3] && bottom != board.rows - 1) continue;
        fitting.push_back({quarters, left - low_column, top - low_row});
      }
    }
  }
  return fitting;
}

std::vector<Observation> observations_of(const Lattice& lattice, const Placement& placement, const Chessboard& board) {
  std::vector<Observation> observations;
  for (const auto& [place, saddle] : lattice) {
    const LatticePlace at = placement.on_board(place);
    if (on_board(at, board)) {
      observations.push_back({saddle.pixel, saddle.sigma_px, at.second * board.columns + at.first});
    }
  }
  std::ranges::sort(observations, {}, &Observation::point_id);
  return observations;
}

/// How far the board's corner (0, 0) points to the top left of the image, from its x and y directions there.
double towards_top_left(const Lattice& lattice, const Placement& placement) {
  double n = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), place_mean = Eigen::Vector2d::Zero();
  for (const auto& [place, saddle] : lattice) {
    const LatticePlace at = placement.on_board(place);
    mean += saddle.pixel;
    place_mean += Eigen::Vector2d(at.first, at.second);
    n += 1;
  }
  mean /= n;
  place_mean /= n;
  double sum = 0;
  for (const auto& [place, saddle] : lattice) {
    const LatticePlace at = placement.on_board(place);
    sum += (at.first + at.second - place_mean.sum()) * (saddle.pixel - mean).sum();
  }
  return sum;
}

/// True when one placement is the other after turning the board onto itself.
bool same_but_turned(const Placement& a, const Placement& b, const Chessboard& board) {
  const LatticePlace at_a = a.on_board({0, 0});
  const LatticePlace at_b = b.on_board({0, 0});
  const Placement turn{(b.quarters - a.quarters + 4) % 4, 0, 0};
  const LatticePlace from_centre{2 * at_a.first - (board.columns - 1), 2 * at_a.second - (board.rows - 1)};
  const LatticePlace turned = turn.on_board(from_centre);
  return turned.first == 2 * at_b.first - (board.columns - 1) && turned.second == 2 * at_b.second - (board.rows - 1) &&
         (turn.quarters % 2 == 0 || board.columns == board.rows);
}

}  // namespace

LatticeBorders closed_sides(const cv::Mat& gray, const Lattice& lattice) {
  if (lattice.empty()) return {};
  const auto closed = [&](const Side& side) { return side_is_closed(gray, lattice, side); };
  return {.low_x = closed(kLeft), .high_x = closed(kRight), .low_y = closed(kTop), .high_y = closed(kBottom)};
}

void drop_lines_on_margin(const cv::Mat& gray, Lattice& lattice) {
  constexpr double kFew = 0.3;  // of the next line's corners: what an accident puts on the margin
  for (const Side& side : {kLeft, kRight, kTop, kBottom}) {
    if (lattice.empty()) return;
    const std::vector<LatticePlace> outermost = places_along(lattice, side);
    Lattice without = lattice;
    for (const LatticePlace& place : outermost) without.erase(place);
    if (without.empty()) return;
    const auto next = static_cast<double>(places_along(without, side).size());
    if (static_cast<double>(outermost.size()) > kFew * next) continue;
    if (side_is_closed(gray, without, side, 1)) lattice = std::move(without);
  }
}

std::optional<std::vector<Observation>> placed_on_board(const Lattice& lattice, const LatticeBorders& closed,
                                                        const Chessboard& board) {
  if (lattice.empty()) return std::nullopt;
  const bool colour_tells = (board.columns + board.rows) % 2 == 1 || board.columns == board.rows;
  std::vector<Placement> placements = placements_of(extent_of(lattice), closed, board);
  if (colour_tells && std::ranges::any_of(placements, starts_dark)) {
    std::erase_if(placements, [](const Placement& placement) { return !starts_dark(placement); });
  }
  if (placements.empty()) return std::nullopt;
  // What is left must be turns of the board onto itself; of those, the one that starts at the top left.
  for (const Placement& placement : placements) {
    if (!same_but_turned(placements.front(), placement, board)) return std::nullopt;
  }
  const auto first = std::ranges::max_element(
      placements, {}, [&](const Placement& placement) { return towards_top_left(lattice, placement); });
  return observations_of(lattice, *first, board);
}

void trim_lattice(Lattice& lattice, const Chessboard& board) {
  constexpr double kSparse = 0.3;  // of a full line: what may be cut as not of the board
  while (!lattice.empty()) {
    const LatticeExtent extent = extent_of(lattice);
    const auto [low, high] = std::minmax({extent.width(), extent.height()});
    const auto [board_low, board_high] = std::minmax({board.columns, board.rows});
    if (low <= board_low && high <= board_high) return;
    std::array<int, 4> count{};
    for (const auto& [place, saddle] : lattice) {
      count[0] += place.first == extent.low_x;
      count[1] += place.second == extent.low_y;
      count[2] += place.first == extent.high_x;
      count[3] += place.second == extent.high_y;
    }
    // Only a side of a dimension that is too long may go.
    std::array<double, 4> share;
    for (int side = 0; side < 4; ++side) {
      const bool across = side % 2 == 0;
      const int length = across ? extent.width() : extent.height();
      const bool too_long = length > (length == high && high != low ? board_high : board_low);
      share[side] = too_long ? count[side] / static_cast<double>(across ? extent.height() : extent.width()) : 2;
    }
    const int sparsest = static_cast<int>(std::ranges::min_element(share) - share.begin());
    if (share[sparsest] > kSparse) return;
    std::erase_if(lattice, [&](const auto& entry) {
      const auto [x, y] = entry.first;
      return sparsest == 0   ? x == extent.low_x
             : sparsest == 1 ? y == extent.low_y
             : sparsest == 2 ? x == extent.high_x
                             : y == extent.high_y;
    });
  }
}

}  // namespace raybundle
