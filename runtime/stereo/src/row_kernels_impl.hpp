// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>

#include "byte_lanes.hpp"
#include "row_kernels.hpp"

// The loops of row_kernels.hpp for one kind of bytes. Included once by the source file of each kind, so that each is
// compiled for its own instructions.

namespace raybundle {
namespace {

constexpr std::uint8_t kNone = 255;

// For all disparities: a window of 255s in the middle of zeros, to take three neighbours out of the race.
constexpr int kMostLanes = 256;
constexpr auto kThreeOut = [] {
  std::array<std::uint8_t, 2 * kMostLanes + kLanes> mask{};
  for (int i = -1; i <= 1; ++i) mask[static_cast<std::size_t>(kMostLanes + i)] = kNone;
  return mask;
}();
// 255 from here on: disparities that were not asked for.
constexpr auto kOutOfRange = [] {
  std::array<std::uint8_t, 2 * kMostLanes> mask{};
  for (std::size_t i = kMostLanes; i < mask.size(); ++i) mask[i] = kNone;
  return mask;
}();

/// The disparities of one pixel in registers.
template <typename Bytes, int n>
struct Column {
  Bytes part[n];

  static Column load(const std::uint8_t* from) {
    Column column;
    for (int j = 0; j < n; ++j) column.part[j] = Bytes::load(from + j * kLanes);
    return column;
  }
  static Column all(std::uint8_t value) {
    Column column;
    for (int j = 0; j < n; ++j) column.part[j] = Bytes::all(value);
    return column;
  }
  void store(std::uint8_t* to) const {
    for (int j = 0; j < n; ++j) part[j].store(to + j * kLanes);
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
  /// The lesser of both neighbours.
  Column neighbours() const {
    const Bytes none = Bytes::all(kNone);
    Column column;
    for (int j = 0; j < n; ++j) {
      column.part[j] = least(Bytes::shifted_up(j == 0 ? none : part[j - 1], part[j]),
                             Bytes::shifted_down(part[j], j == n - 1 ? none : part[j + 1]));
    }
    return column;
  }
  /// The same for a column in memory that stands between 255s.
  static Column neighbours(const std::uint8_t* from) {
    Column column;
    for (int j = 0; j < n; ++j) {
      column.part[j] = least(Bytes::load(from + j * kLanes - 1), Bytes::load(from + j * kLanes + 1));
    }
    return column;
  }
};

/// A path reaches the next pixel: costs plus the cheapest way from the pixel before. Costs of a path are counted from
/// its cheapest disparity, so that they stay below the most cost of a pixel plus one large step.
/// Source: Hirschmüller, Stereo Processing by Semiglobal Matching and Mutual Information, PAMI 2008, eq. 13.
template <typename Bytes, int n>
Column<Bytes, n> next_on_path(const Column<Bytes, n>& before, const Column<Bytes, n>& neighbours,
                              const Column<Bytes, n>& costs, Bytes small_step, Bytes large_step) {
  Column<Bytes, n> path;
  for (int j = 0; j < n; ++j) {
    const Bytes way = least(least(before.part[j], add(neighbours.part[j], small_step)), large_step);
    path.part[j] = add(way, costs.part[j]);
  }
  const Bytes lowest = path.spread_least();
  for (int j = 0; j < n; ++j) path.part[j] = subtract(path.part[j], lowest);
  return path;
}

template <typename Bytes, int n>
void take_best(const Column<Bytes, n>& sums, const std::uint8_t* costs, const BestRow& best, int x) {
  const Bytes lowest = sums.spread_least();
  int disparity = 0;
  for (int j = n - 1; j >= 0; --j) {
    const std::uint32_t equal = equal_lanes(sums.part[j], lowest);
    if (equal != 0) disparity = j * kLanes + std::countr_zero(equal);
  }
  Column<Bytes, n> others;
  for (int j = 0; j < n; ++j) {
    others.part[j] = sums.part[j] | Bytes::load(kThreeOut.data() + kMostLanes + j * kLanes - disparity);
  }
  best.disparity[x] = static_cast<std::uint8_t>(disparity);
  best.sum[x] = lowest.first();
  best.second[x] = others.spread_least().first();
  best.before[x] = disparity > 0 ? costs[disparity - 1] : kNone;
  best.cost[x] = costs[disparity];
  best.after[x] = disparity < n * kLanes - 1 ? costs[disparity + 1] : kNone;
}

template <typename Bytes, int n>
void paths_row(const PathRow& row) {
  using Pixel = Column<Bytes, n>;
  constexpr std::ptrdiff_t kColumn = n * kLanes;
  constexpr std::ptrdiff_t kSlot = kColumn + kLanes;  // with the 255s behind it
  const Bytes small_step = Bytes::all(row.small_step);
  const Bytes large_step = Bytes::all(row.large_step);
  const int width = row.width;

  // A diagonal keeps its slot: from above on the left it is x - row, from above on the right x + row, around the row.
  int from_left = (width - row.row % width) % width;
  int from_right = row.row % width;
  Pixel path = Pixel::all(0);
  for (int x = 0; x < width; ++x) {
    const Pixel costs = Pixel::load(row.costs + x * kColumn);
    path = next_on_path(path, path.neighbours(), costs, small_step, large_step);
    Pixel sum = path;
    const int slots[3] = {x, from_left, from_right};
    const bool starts[3] = {row.row == 0, row.row == 0 || x == 0, row.row == 0 || x == width - 1};
    for (int k = 0; k < 3; ++k) {
      std::uint8_t* slot = row.above[k] + slots[k] * kSlot;
      Pixel from_above = starts[k]
                             ? next_on_path(Pixel::all(0), Pixel::all(0), costs, small_step, large_step)
                             : next_on_path(Pixel::load(slot), Pixel::neighbours(slot), costs, small_step, large_step);
      from_above.store(slot);
      sum += from_above;
    }
    sum.store(row.sums + x * kColumn);
    from_left = from_left + 1 == width ? 0 : from_left + 1;
    from_right = from_right + 1 == width ? 0 : from_right + 1;
  }

  const Pixel out_of_range = Pixel::load(kOutOfRange.data() + kMostLanes - row.disparities);
  path = Pixel::all(0);
  for (int x = width - 1; x >= 0; --x) {
    path = next_on_path(path, path.neighbours(), Pixel::load(row.costs + x * kColumn), small_step, large_step);
    Pixel sum = Pixel::load(row.sums + x * kColumn);
    sum += path;
    sum += out_of_range;
    take_best(sum, row.costs + x * kColumn, row.best, x);
  }
}

template <typename Bytes, int n>
void best_row(const PathRow& row) {
  using Pixel = Column<Bytes, n>;
  const Pixel out_of_range = Pixel::load(kOutOfRange.data() + kMostLanes - row.disparities);
  for (int x = 0; x < row.width; ++x) {
    Pixel costs = Pixel::load(row.costs + x * n * kLanes);
    costs += out_of_range;
    take_best(costs, row.costs + x * n * kLanes, row.best, x);
  }
}

template <typename Bytes>
void census_row(const CensusRow& row) {
  for (int x = 0; x < row.width; x += kLanes) {
    const Bytes centre = Bytes::load(row.centre + x);
    for (std::size_t k = 0; k < row.offsets.size(); k += 4) {
      Bytes code = Bytes::all(0);
      for (std::size_t bit = 0; bit < 4 && k + bit < row.offsets.size(); ++bit) {
        const Bytes neighbour = Bytes::load(row.centre + x + row.offsets[k + bit]);
        code = code | (at_least(neighbour, centre) & Bytes::all(static_cast<std::uint8_t>(1 << bit)));
      }
      code.store(row.codes + static_cast<std::ptrdiff_t>(k / 4) * row.plane_stride + x);
    }
  }
}

template <typename Bytes, int n>
void census_cost_row(const CensusCostRow& row) {
  for (int x = 0; x < row.width; ++x) {
    const std::ptrdiff_t mirrored = row.width - 1 - x;
    Column<Bytes, n> costs = Column<Bytes, n>::all(0);
    for (int k = 0; k < row.planes; ++k) {
      const Bytes left = Bytes::all(row.left_codes[k * row.plane_stride + x]);
      const std::uint8_t* right = row.right_codes + k * row.plane_stride + mirrored;
      for (int j = 0; j < n; ++j) {
        costs.part[j] = add(costs.part[j], Bytes::difference(left, Bytes::load(right + j * kLanes), row.nibble_costs));
      }
    }
    for (int j = 0; j < n; ++j) {
      costs.part[j] = most(costs.part[j], Bytes::load(row.right_limits + mirrored + j * kLanes));
    }
    costs.store(row.costs + x * n * kLanes);
  }
}

template <typename Bytes, int n>
void smooth_row(const SmoothRow& row) {
  using Pixel = Column<Bytes, n>;
  const auto column = [&](int x) {
    Pixel sum;
    for (int j = 0; j < n; ++j) {
      const std::ptrdiff_t at = (static_cast<std::ptrdiff_t>(x) * n + j) * kLanes;
      const Bytes outer = average(Bytes::load(row.from[0] + at), Bytes::load(row.from[2] + at));
      sum.part[j] = average(outer, Bytes::load(row.from[1] + at));
    }
    return sum;
  };
  Pixel before = column(0);
  Pixel here = before;
  for (int x = 0; x < row.width; ++x) {
    const Pixel behind = column(x + 1 < row.width ? x + 1 : x);
    Pixel smooth;
    for (int j = 0; j < n; ++j) smooth.part[j] = average(average(before.part[j], behind.part[j]), here.part[j]);
    smooth.store(row.costs + x * n * kLanes);
    before = here;
    here = behind;
  }
}

template <template <int> typename Call, typename Row>
void with_columns(const Row& row) {
  switch (row.lanes / kLanes) {
    case 1:
      return Call<1>::of(row);
    case 2:
      return Call<2>::of(row);
    case 3:
      return Call<3>::of(row);
    case 4:
      return Call<4>::of(row);
    case 6:
      return Call<6>::of(row);
    default:
      return Call<8>::of(row);
  }
}

template <typename Bytes>
struct Kernels {
  template <int n>
  struct CensusCosts {
    static void of(const CensusCostRow& row) { census_cost_row<Bytes, n>(row); }
  };
  template <int n>
  struct Smooth {
    static void of(const SmoothRow& row) { smooth_row<Bytes, n>(row); }
  };
  template <int n>
  struct Paths {
    static void of(const PathRow& row) { paths_row<Bytes, n>(row); }
  };
  template <int n>
  struct Best {
    static void of(const PathRow& row) { best_row<Bytes, n>(row); }
  };
  static constexpr RowKernels kTable{census_row<Bytes>, with_columns<CensusCosts, CensusCostRow>,
                                     with_columns<Smooth, SmoothRow>, with_columns<Paths, PathRow>,
                                     with_columns<Best, PathRow>};
};

}  // namespace
}  // namespace raybundle
