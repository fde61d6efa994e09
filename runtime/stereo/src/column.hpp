// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "byte_lanes.hpp"

namespace raybundle {
namespace {

constexpr std::uint8_t kNone = 255;

// Take the first or the last lane out of the race.
constexpr auto kFirstOut = [] {
  std::array<std::uint8_t, kLanes> mask{};
  mask.front() = kNone;
  return mask;
}();
constexpr auto kLastOut = [] {
  std::array<std::uint8_t, kLanes> mask{};
  mask.back() = kNone;
  return mask;
}();

/// The disparities of one pixel in registers.
template <typename Bytes, int n>
struct Column {
  Bytes part[n];

  static Column load(const std::uint8_t* from) {
    Column column;
    for (int j = 0; j < n; ++j) column.part[j] = Bytes::load(from + j * Bytes::kCount);
    return column;
  }
  static Column all(std::uint8_t value) {
    Column column;
    for (int j = 0; j < n; ++j) column.part[j] = Bytes::all(value);
    return column;
  }
  void store(std::uint8_t* to) const {
    for (int j = 0; j < n; ++j) part[j].store(to + j * Bytes::kCount);
  }
  Bytes spread_least() const {
    Bytes value = part[0];
    for (int j = 1; j < n; ++j) value = least(value, part[j]);
    return value.spread_least();
  }
  Column& operator+=(const Column& other) {
    for (int j = 0; j < n; ++j) part[j] = add(part[j], other.part[j]);
    return *this;
  }
  Column& operator-=(const Column& other) {
    for (int j = 0; j < n; ++j) part[j] = subtract(part[j], other.part[j]);
    return *this;
  }
  /// The lesser of both neighbours of each disparity of a column in memory, around which there is a byte more.
  static Column neighbours_at(const std::uint8_t* from) {
    Column column;
    for (int j = 0; j < n; ++j) {
      Bytes above = Bytes::load(from + j * Bytes::kCount - 1), below = Bytes::load(from + j * Bytes::kCount + 1);
      if (j == 0) above = above | Bytes::load(kFirstOut.data());
      if (j == n - 1) below = below | Bytes::load(kLastOut.data());
      column.part[j] = least(above, below);
    }
    return column;
  }
  /// The same of a column in registers.
  Column neighbours() const {
    const Bytes none = Bytes::all(kNone);
    Column column;
    for (int j = 0; j < n; ++j) {
      column.part[j] = least(Bytes::shifted_up(j == 0 ? none : part[j - 1], part[j]),
                             Bytes::shifted_down(part[j], j == n - 1 ? none : part[j + 1]));
    }
    return column;
  }
};

}  // namespace
}  // namespace raybundle
