// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "alike_boards.hpp"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>

#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

constexpr const char* kNoMarkers = "neither carries markers, and part of one looks like part of the other";
constexpr const char* kSameMarkers = "both carry the same markers";

bool is_circles(const Board& board) {
  return std::holds_alternative<Circles>(board) || std::holds_alternative<AsymmetricCircles>(board);
}

// What a detector sees of a board's markers: codes first to last of one kind.
struct Markers {
  std::string code;
  bool inverted = false;
  int border_bits = 1;
  int first = 0, last = 0;

  bool share_some_with(const Markers& other) const {
    return code == other.code && inverted == other.inverted && border_bits == other.border_bits &&
           first <= other.last && other.first <= last;
  }
};

// A dictionary of 50 holds the first codes of the one of 1000: 4X4_50 is 4X4; DICT_APRILTAG_36h11 is 36h11.
std::string code_of(std::string_view dictionary) {
  for (const std::string_view prefix : {"DICT_APRILTAG_", "DICT_"}) {
    if (dictionary.starts_with(prefix)) dictionary.remove_prefix(prefix.size());
  }
  return std::string(dictionary.substr(0, dictionary.find('_')));
}

std::optional<Markers> markers_of(const Board& board) {
  if (const auto* charuco = std::get_if<Charuco>(&board)) {
    const int most = (charuco->columns * charuco->rows + 1) / 2;  // every other square
    return Markers{code_of(charuco->dictionary), charuco->inverted, 1, 0, most - 1};
  }
  if (const auto* grid = std::get_if<AprilGrid>(&board)) {
    const int last = grid->first_tag + grid->columns * grid->rows - 1;
    return Markers{code_of(grid->family), false, grid->border_bits, grid->first_tag, last};
  }
  return std::nullopt;
}

// Why an image does not tell two boards apart; null when it does.
const char* why_alike(const Board& a, const Board& b) {
  const bool chessboards = std::holds_alternative<Chessboard>(a) && std::holds_alternative<Chessboard>(b);
  if (chessboards || (is_circles(a) && is_circles(b))) return kNoMarkers;
  const std::optional<Markers> of_a = markers_of(a), of_b = markers_of(b);
  return of_a && of_b && of_a->share_some_with(*of_b) ? kSameMarkers : nullptr;
}

}  // namespace

void refuse_alike_boards(const std::vector<DatasetBoard>& boards) {
  for (std::size_t b = 1; b < boards.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const char* why = why_alike(boards[a].board, boards[b].board);
      if (why == nullptr) continue;
      throw Error(ErrorKind::kBadInput,
                  fmt::format("images do not tell [[target]] '{}' from '{}', as {}; use ChArUco boards with markers of "
                              "different sizes (4X4, 5X5, ...) or AprilGrids of different first_tag, or leave one of "
                              "the two out",
                              boards[a].name, boards[b].name, why));
    }
  }
}

}  // namespace raybundle::apps
