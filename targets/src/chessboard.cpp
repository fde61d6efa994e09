// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "chessboard.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "lattice.hpp"
#include "lattice_place.hpp"
#include "lattice_size.hpp"

namespace raybundle {
namespace {

/// Half the size, a level after the other, as long as a board could be seen.
std::vector<cv::Mat> pyramid_of(const cv::Mat& gray) {
  constexpr int kSmallest_px = 120;
  std::vector<cv::Mat> levels{gray};
  while (levels.size() < 5 && std::min(levels.back().cols, levels.back().rows) >= 2 * kSmallest_px) {
    cv::Mat half;
    cv::resize(levels.back(), half, {levels.back().cols / 2, levels.back().rows / 2}, 0, 0, cv::INTER_AREA);
    levels.push_back(half);
  }
  return levels;
}

/// The order in which levels are searched: about half of VGA first, which is cheap and forgives noise, then finer, then
/// coarser.
std::vector<int> search_order(const std::vector<cv::Mat>& levels) {
  constexpr int kFirst_px = 500;
  int first = 0;
  while (first + 1 < static_cast<int>(levels.size()) && std::max(levels[first].cols, levels[first].rows) > kFirst_px)
    ++first;
  std::vector<int> order;
  for (int level = first; level >= 0; --level) order.push_back(level);
  for (int level = first + 1; level < static_cast<int>(levels.size()); ++level) order.push_back(level);
  return order;
}

/// The lattice in pixels of the full image.
Lattice in_full_image(Lattice lattice, const cv::Mat& level, const cv::Mat& full) {
  const Eigen::Array2d scale(static_cast<double>(full.cols) / level.cols, static_cast<double>(full.rows) / level.rows);
  for (auto& [place, saddle] : lattice) {
    saddle.pixel = ((saddle.pixel.array() + 0.5) * scale - 0.5).matrix();
    saddle.sigma_px *= scale.x();
    saddle.blur_px *= scale.x();
  }
  return lattice;
}

/// Grows at full resolution; an image that is too blurred for that grows at the level where it was seen.
///
/// @param all  corners of the board: seeds may hold more, on what is no board
Lattice grown(const std::vector<cv::Mat>& levels, int level, const Lattice& seed, int longest, std::size_t all) {
  Lattice fine = in_full_image(seed, levels[level], levels[0]);
  grow_lattice(levels[0], fine, longest);
  if (level == 0 || fine.size() >= std::min(seed.size(), all)) return fine;
  Lattice coarse = seed;
  grow_lattice(levels[level], coarse, longest);
  coarse = in_full_image(coarse, levels[level], levels[0]);
  return coarse.size() > fine.size() ? coarse : fine;
}

}  // namespace

Detection detect_chessboard(const cv::Mat& gray, const Chessboard& board) {
  constexpr int kTooSmall_px = 16;
  if (std::min(gray.cols, gray.rows) < kTooSmall_px) return {};
  const std::vector<cv::Mat> levels = pyramid_of(gray);
  const std::size_t all = static_cast<std::size_t>(board.columns) * static_cast<std::size_t>(board.rows);
  const int longest = std::max(board.columns, board.rows) + 2;
  Detection best;
  Lattice unplaced;  // the largest lattice that did not fit
  for (const int level : search_order(levels)) {
    cv::Mat blurred;
    cv::GaussianBlur(levels[level], blurred, {5, 5}, 1.0);
    std::vector<Lattice> lattices = linked_lattices(saddle_candidates(blurred), blurred);
    if (lattices.size() > 3) lattices.resize(3);
    for (const Lattice& seed : lattices) {
      if (4 * seed.size() < lattices.front().size()) break;  // largest first
      if (seed.size() <= best.observations.size() / 2) break;
      Lattice lattice = grown(levels, level, seed, longest, all);
      trim_lattice(lattice, board);
      if (lattice.size() != all) drop_lines_on_margin(levels[0], lattice);
      Detection placed = detection_on_lattice(lattice, closed_sides(levels[0], lattice), board);
      if (placed.observations.empty() && lattice.size() > unplaced.size()) unplaced = lattice;
      if (placed.observations.size() > best.observations.size()) best = std::move(placed);
      if (best.observations.size() == all) return best;
    }
  }
  if (best.observations.empty() && !unplaced.empty()) {
    constexpr int kAnySize = 60;
    grow_lattice(levels[0], unplaced, kAnySize);
    best = unplaced_lattice(unplaced, closed_sides(levels[0], unplaced), board);
  }
  return best;
}

}  // namespace raybundle
