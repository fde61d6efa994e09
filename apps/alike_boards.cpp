// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "alike_boards.hpp"

#include <fmt/format.h>

#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

constexpr const char* kNoMarkers = "neither carries markers, and part of one looks like part of the other";
constexpr const char* kSameMarkers = "both carry the same markers";

bool is_circles(const Board& board) {
  return std::holds_alternative<Circles>(board) || std::holds_alternative<AsymmetricCircles>(board);
}

bool share_markers(const Charuco& a, const Charuco& b) {  // markers of each count from 0
  return a.dictionary == b.dictionary && a.inverted == b.inverted;
}

bool share_markers(const AprilGrid& a, const AprilGrid& b) {
  const bool apart = a.first_tag + a.columns * a.rows <= b.first_tag || b.first_tag + b.columns * b.rows <= a.first_tag;
  return a.family == b.family && a.border_bits == b.border_bits && !apart;
}

template <typename Kind>
bool share_markers(const Board& a, const Board& b) {
  return std::holds_alternative<Kind>(a) && std::holds_alternative<Kind>(b) &&
         share_markers(std::get<Kind>(a), std::get<Kind>(b));
}

// Why an image does not tell two boards apart; null when it does.
const char* why_alike(const Board& a, const Board& b) {
  const bool chessboards = std::holds_alternative<Chessboard>(a) && std::holds_alternative<Chessboard>(b);
  if (chessboards || (is_circles(a) && is_circles(b))) return kNoMarkers;
  return share_markers<Charuco>(a, b) || share_markers<AprilGrid>(a, b) ? kSameMarkers : nullptr;
}

}  // namespace

void refuse_alike_boards(const std::vector<DatasetBoard>& boards) {
  for (std::size_t b = 1; b < boards.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const char* why = why_alike(boards[a].board, boards[b].board);
      if (why == nullptr) continue;
      throw Error(ErrorKind::kBadInput,
                  fmt::format("images do not tell [[target]] '{}' from '{}', as {}; use ChArUco boards of different "
                              "dictionaries or AprilGrids of different first_tag, or leave one of the two out",
                              boards[a].name, boards[b].name, why));
    }
  }
}

}  // namespace raybundle::apps
