// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "board_dictionary.hpp"
#include "charuco.hpp"
#include "raybundle/geometry/quantile.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kFewestMarkers = 3;  // fewer that agree are an accident
// One of each size of code is enough: the smaller dictionaries are the first codes of the larger ones.
constexpr std::array<const char*, 7> kCommonDictionaries{
    "DICT_4X4_1000",       "DICT_5X5_1000",       "DICT_6X6_1000",     "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_36h11", "DICT_APRILTAG_16h5"};

std::size_t agreeing(const MarkerSearch& search, const Charuco& board) {
  return consistent_markers(search.markers, charuco_layout(board)).size();
}

// A flag of the board as it is written in a word and in TOML.
std::string setting(const char* name, bool value) {
  return fmt::format("{}:{} (in TOML {} = {})", value ? "" : "without ", name, name, value);
}

// The setting under which more than half of the markers agree.
std::string layout_hint(const MarkerSearch& search, const Charuco& board) {
  Charuco other = board;
  other.legacy = !board.legacy;
  const std::size_t seen = search.markers.size();
  const std::size_t agree = agreeing(search, other);
  if (agree >= kFewestMarkers && agree > agreeing(search, board)) {
    return fmt::format("{} markers seen, but they stand as on a board of the {} layout: try {}", seen,
                       other.legacy ? "legacy" : "new", setting("legacy", other.legacy));
  }
  return {};
}

// A code's mirror image is another code or none.
std::string mirror_hint(const cv::Mat& upright, const Charuco& board, const MarkerSearch& search) {
  if (search.markers.size() + search.unread.size() < kFewestMarkers) return {};
  cv::Mat flipped;
  cv::flip(upright, flipped, 1);
  const std::size_t agree = agreeing(find_markers(flipped, dictionary_named(board.dictionary), 1), board);
  if (agree < kFewestMarkers || agree <= agreeing(search, board)) return {};
  return fmt::format("{} markers are read in the image's mirror image: {}", agree, kMirrored);
}

// The middle of a marker or of its place on the board.
Eigen::Vector2d centre(const std::array<Eigen::Vector2d, 4>& corners) {
  return 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
}

double mean_side(const std::array<Eigen::Vector2d, 4>& corners) {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) sum += (corners[(k + 1) % 4] - corners[k]).norm();
  return 0.25 * sum;
}

// How large markers are against squares shows in how far apart neighbours stand, whatever the lens and the pose.
std::string size_hint(const MarkerSearch& search, const Charuco& board) {
  constexpr double kNeighbours = 1.5;  // squares: those on a diagonal
  constexpr double kAgreement = 0.15;  // of the size, which perspective and distortion hardly exceed
  const MarkerLayout layout = charuco_layout(board);
  std::vector<double> sizes_m;
  for (const Marker& a : search.markers) {
    for (const Marker& b : search.markers) {
      const auto known = static_cast<int>(layout.size());
      if (a.id >= b.id || a.id >= known || b.id >= known) continue;
      const double apart_m = (centre(layout[a.id]) - centre(layout[b.id])).norm();
      if (apart_m > kNeighbours * board.square_m) continue;
      const double side_px = 0.5 * (mean_side(a.corners) + mean_side(b.corners));
      sizes_m.push_back(side_px * apart_m / (centre(a.corners) - centre(b.corners)).norm());
    }
  }
  if (sizes_m.size() < kFewestMarkers) return {};
  const double size_m = median(sizes_m);
  const auto alike = [&](double other_m) { return std::abs(other_m - size_m) < kAgreement * size_m; };
  if (4 * std::ranges::count_if(sizes_m, alike) < 3 * std::ssize(sizes_m) || alike(board.marker_m)) return {};
  return fmt::format("the markers seen are about {:.3g} mm wide if squares are {:.3g} mm, not {:.3g} mm: measure both",
                     1e3 * size_m, 1e3 * board.square_m, 1e3 * board.marker_m);
}

// Markers are read by their dark squares; the corners between them need more pixels.
std::string corner_hint(const MarkerSearch& search, const Charuco& board) {
  const std::size_t agree = agreeing(search, board);
  if (agree < kFewestMarkers) return {};
  std::vector<double> sides_px;
  for (const Marker& marker : search.markers) sides_px.push_back(mean_side(marker.corners));
  return fmt::format(
      "{} markers are read, but hardly a corner between their squares, which are about {:.0f} px wide: go nearer, or "
      "take larger or sharper images",
      agree, median(sides_px) * board.square_m / board.marker_m);
}

}  // namespace

std::string charuco_hint(const cv::Mat& upright, const Charuco& board, const MarkerSearch& search) {
  if (std::string hint = layout_hint(search, board); !hint.empty()) return hint;
  if (std::string hint = mirror_hint(upright, board, search); !hint.empty()) return hint;
  if (std::string hint = size_hint(search, board); !hint.empty()) return hint;
  if (search.markers.size() >= kFewestMarkers && agreeing(search, board) < kFewestMarkers) {
    return fmt::format(
        "{} markers of {} seen, but they do not stand as on a board of {} x {} squares: check columns and rows",
        search.markers.size(), board.dictionary, board.columns, board.rows);
  }
  if (std::string hint = corner_hint(search, board); !hint.empty()) return hint;
  cv::Mat inverse;
  cv::bitwise_not(upright, inverse);
  const MarkerSearch inverted = find_markers(inverse, dictionary_named(board.dictionary), 1);
  Charuco other = board;
  other.legacy = !board.legacy;
  if (const std::size_t agree = std::max(agreeing(inverted, board), agreeing(inverted, other));
      agree >= kFewestMarkers) {
    const std::string legacy =
        agreeing(inverted, other) > agreeing(inverted, board) ? " and " + setting("legacy", other.legacy) : "";
    return fmt::format("{} markers seen with black and white exchanged: try {}{}", agree,
                       setting("inverted", !board.inverted), legacy);
  }
  // Without quadrilaterals there is nothing that another dictionary could read.
  if (search.unread.size() < kFewestMarkers) return {};
  for (const char* name : kCommonDictionaries) {
    if (name == board.dictionary) continue;
    const auto dictionary = dictionary_named(name);
    const auto read =
        std::ranges::count_if(search.unread, [&](const Quad& quad) { return reads_as(upright, quad, dictionary); });
    if (read >= static_cast<std::ptrdiff_t>(2 * kFewestMarkers)) {
      return fmt::format("{} markers of {} seen, none of {}: check the dictionary", read, name, board.dictionary);
    }
  }
  return {};
}

}  // namespace raybundle
