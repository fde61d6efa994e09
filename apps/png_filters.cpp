// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "png_filters.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

#include "raybundle/geometry/target_clones.hpp"

namespace raybundle::apps {
namespace {

// Within a row each pixel waits for the one to its left. So eight rows are undone at once, each row a pixel behind the
// one above it: all that a pixel needs is known a step before.
constexpr int kRows = 8;
using Lanes [[gnu::vector_size(2 * kRows)]] = std::int16_t;  // of each row a pixel
using Bytes [[gnu::vector_size(kRows)]] = std::uint8_t;
using Block = std::array<std::uint64_t, kRows>;  // eight pixels of eight rows

static_assert(std::endian::native == std::endian::little, "the first pixel of eight is the lowest byte of a word");

enum Filter { kNone, kLeft, kAbove, kMean, kPaeth, kFilters };

struct Rows {
  const std::uint8_t* filtered[kRows];
  std::uint8_t* pixels[kRows];
  int count = 0;
  Lanes uses[kFilters] = {};  // all bits of the rows that have this filter
};

Block transposed(Block block) {
  const auto swap = [&](int distance, std::uint64_t mask) {
    for (int i = 0; i < kRows; ++i) {
      if (i & distance) continue;
      std::uint64_t &upper = block[i], &lower = block[i + distance];
      const std::uint64_t change = ((upper >> (8 * distance)) ^ lower) & mask;
      lower ^= change;
      upper ^= change << (8 * distance);
    }
  };
  swap(1, 0x00ff00ff00ff00ffU);
  swap(2, 0x0000ffff0000ffffU);
  swap(4, 0x00000000ffffffffU);
  return block;
}

// Pixels `first` to `first` + 7 of a row, 0 where there are none.
std::uint64_t eight(const std::uint8_t* row, int first, int width) {
  std::uint64_t word = 0;
  if (first >= 0 && first + 8 <= width) {
    std::memcpy(&word, row + first, 8);
  } else {
    for (int x = std::max(first, 0); x < std::min(first + 8, width); ++x) {
      word |= static_cast<std::uint64_t>(row[x]) << (8 * (x - first));
    }
  }
  return word;
}

void put_eight(std::uint64_t word, std::uint8_t* row, int first, int width) {
  if (first >= 0 && first + 8 <= width) {
    std::memcpy(row + first, &word, 8);
  } else {
    for (int x = std::max(first, 0); x < std::min(first + 8, width); ++x) {
      row[x] = static_cast<std::uint8_t>(word >> (8 * (x - first)));
    }
  }
}

Lanes size_of(const Lanes& value) { return value < 0 ? -value : value; }

// What Paeth's filter predicts: of left, above and the corner between them the one next to left + above - corner.
Lanes paeth(const Lanes& left, const Lanes& above, const Lanes& corner) {
  const Lanes rise = above - corner, run = left - corner;
  const Lanes from_left = size_of(rise), from_above = size_of(run), from_corner = size_of(rise + run);
  const Lanes not_left = from_above <= from_corner ? above : corner;
  return ((from_left <= from_above) & (from_left <= from_corner)) ? left : not_left;
}

// `over` is the row above the first one.
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] void undo(const Rows& rows, const std::uint8_t* over, int width) {
  Lanes left = {}, corner = {};
  for (int begin = 0; begin < width + kRows - 1; begin += 8) {
    Block block = {};
    for (int k = 0; k < rows.count; ++k) block[k] = eight(rows.filtered[k], begin - k, width);
    block = transposed(block);
    const std::uint64_t above_first = eight(over, begin, width);
    for (int step = 0; step < 8; ++step) {
      Lanes above = __builtin_shufflevector(left, left, 0, 0, 1, 2, 3, 4, 5, 6);
      above[0] = static_cast<std::uint8_t>(above_first >> (8 * step));
      const Lanes predicted = (rows.uses[kLeft] & left) | (rows.uses[kAbove] & above) |
                              (rows.uses[kMean] & ((left + above) >> 1)) |
                              (rows.uses[kPaeth] & paeth(left, above, corner));
      const Lanes difference = __builtin_convertvector(std::bit_cast<Bytes>(block[step]), Lanes);
      left = (difference + predicted) & 0xff;
      corner = above;
      block[step] = std::bit_cast<std::uint64_t>(__builtin_convertvector(left, Bytes));
    }
    block = transposed(block);
    for (int k = 0; k < rows.count; ++k) put_eight(block[k], rows.pixels[k], begin - k, width);
  }
}

}  // namespace

bool undo_png_filters(const std::uint8_t* filtered, cv::Mat& image) {
  const cv::Mat nothing(1, image.cols, CV_8U, cv::Scalar(0));
  for (int y = 0; y < image.rows; y += kRows) {
    Rows rows;
    rows.count = std::min(kRows, image.rows - y);
    for (int k = 0; k < rows.count; ++k) {
      const std::uint8_t filter = *filtered++;
      if (filter >= kFilters) return false;
      rows.uses[filter][k] = -1;
      rows.filtered[k] = filtered;
      rows.pixels[k] = image.ptr<std::uint8_t>(y + k);
      filtered += image.cols;
    }
    undo(rows, y == 0 ? nothing.ptr<std::uint8_t>(0) : image.ptr<std::uint8_t>(y - 1), image.cols);
  }
  return true;
}

}  // namespace raybundle::apps
