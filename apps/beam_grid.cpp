// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_grid.hpp"

#include <fmt/format.h>

#include <array>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/number.hpp"

namespace raybundle::apps {

std::optional<LaserGrid> beam_grid_from_word(const std::string& word, int least) {
  constexpr int kMost = 64;
  const auto [columns, rows] = two_numbers_from<int>(word, 'x').value_or(std::array{0, 0});
  if (columns < least || columns > kMost || rows < least || rows > kMost) return std::nullopt;
  return LaserGrid{rows, columns};
}

LaserGrid beam_grid_from_flag(const std::string& word) {
  if (const std::optional<LaserGrid> grid = beam_grid_from_word(word, 2)) return *grid;
  throw Error(ErrorKind::kBadInput,
              fmt::format("--beams {} is not COLUMNSxROWS of 2 to 64 beams each way, as in 19x16", word));
}

}  // namespace raybundle::apps
