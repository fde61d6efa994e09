// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>

namespace raybundle {

/// Pixels that belong to somebody else: `height` rows of `width` values, `stride` values apart. Never owns, never
/// copies.
template <typename Value>
struct ImageView {
  Value* pixels = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  ///< values from a row to the next; at least width

  Value* row(int v) const {
    assert(v >= 0 && v < height);
    return pixels + v * stride;
  }
  Value& at(int u, int v) const {
    assert(u >= 0 && u < width);
    return row(v)[u];
  }
};

using GreyView = ImageView<const std::uint8_t>;

}  // namespace raybundle
