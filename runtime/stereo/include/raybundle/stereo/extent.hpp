// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace raybundle {

/// Pixels begin to end - 1 of a row. Of a fisheye that is rectified as a whole, corners show nothing: rows are worked
/// on from the first to the last pixel that shows something.
struct Extent {
  int begin = 0;
  int end = 0;

  /// From the first to the last pixel that is covered. nullptr: all are.
  static Extent of(const std::uint8_t* covered, int width) {
    Extent extent{0, width};
    if (covered == nullptr) return extent;
    while (extent.begin < width && covered[extent.begin] == 0) ++extent.begin;
    while (extent.end > extent.begin && covered[extent.end - 1] == 0) --extent.end;
    return extent;
  }

  bool empty() const { return end <= begin; }

  /// What both reach, and `margin` beyond, within the width.
  Extent with(Extent other, int margin, int width) const {
    if (other.empty()) return *this;
    const Extent wide{std::max(0, other.begin - margin), std::min(width, other.end + margin)};
    return empty() ? wide : Extent{std::min(begin, wide.begin), std::max(end, wide.end)};
  }

  /// Sets the rest of a row.
  template <typename Value>
  void fill_beyond(Value* row, int width, Value value) const {
    std::fill(row, row + begin, value);
    std::fill(row + end, row + width, value);
  }
};

}  // namespace raybundle
