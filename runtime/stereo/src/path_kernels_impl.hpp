// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>

#include "column.hpp"
#include "raybundle/stereo/match.hpp"
#include "row_kernels.hpp"
#include "sub_pixel.hpp"

// Paths and the best disparity, for one kind of bytes.

namespace raybundle {
namespace {

// Standard deviation of a disparity that paths have found, before it is refined [px]. Where windows are alike it is that
// of texture that hardly tells; where half of their census bits differ they have nothing in common, and what the paths
// brought along is steps of disparity off. Both as boards of known shape show in images of three pairs of cameras.
constexpr float kSigmaOfEqual = 0.4F;
constexpr float kSigmaPerShare = 2.5F;  // of the largest cost

// For all disparities: a window of 255s in the middle of zeros, to take three neighbours out of the race.
constexpr int kMostLanes = 256;
constexpr auto kThreeOut = [] {
  std::array<std::uint8_t, 2 * kMostLanes + 2 * kLanes> mask{};
  for (int i = -1; i <= 1; ++i) mask[static_cast<std::size_t>(kMostLanes + i)] = kNone;
  return mask;
}();
// 255 from here on: disparities that were not asked for.
constexpr auto kOutOfRange = [] {
  std::array<std::uint8_t, 2 * kMostLanes> mask{};
  for (std::size_t i = kMostLanes; i < mask.size(); ++i) mask[i] = kNone;
  return mask;
}();

template <typename Bytes, int n>
Column<Bytes, n> path_costs(const std::uint8_t* fine) {
  Column<Bytes, n> costs = Column<Bytes, n>::load(fine);
  for (int j = 0; j < n; ++j) costs.part[j] = quarter(costs.part[j]);
  return costs;
}

/// A path reaches the next pixel: costs plus the cheapest way from the pixel before, counted from the cheapest there,
/// so that it stays below the most cost of a pixel plus one large step.
/// Source: Hirschmüller, Stereo Processing by Semiglobal Matching and Mutual Information, PAMI 2008, eq. 13.
template <typename Bytes, int n>
Column<Bytes, n> next_on_path(const Column<Bytes, n>& before, const Column<Bytes, n>& neighbours,
                              const Column<Bytes, n>& costs, Bytes small_step, std::uint32_t large_step) {
  const Bytes lowest = before.spread_least();
  const Bytes large = add(lowest, Bytes::repeated(large_step));
  Column<Bytes, n> path;
  for (int j = 0; j < n; ++j) {
    const Bytes way = least(least(before.part[j], add(neighbours.part[j], small_step)), large);
    path.part[j] = add(subtract(way, lowest), costs.part[j]);
  }
  return path;
}

/// Both directions in one loop: each waits for its pixel before, and the processor works on the other meanwhile.
template <typename Bytes, int n>
void across_row(PathRow row) {
  using Pixel = Column<Bytes, n>;
  constexpr std::ptrdiff_t kColumn = n * Bytes::kCount;
  const Bytes small_step = Bytes::all(row.small_step);
  Pixel from_left = Pixel::all(0);
  Pixel from_right = Pixel::all(0);
  for (int x = row.extent.begin, y = row.extent.end - 1; x < row.extent.end; ++x, --y) {
    from_left = next_on_path(from_left, from_left.neighbours(), path_costs<Bytes, n>(row.costs + x * kColumn),
                             small_step, row.large_across[x]);
    from_left.store(row.from_left + x * kColumn);
    from_right = next_on_path(from_right, from_right.neighbours(), path_costs<Bytes, n>(row.costs + y * kColumn),
                              small_step, row.large_across[y + 1]);
    from_right.store(row.from_right + y * kColumn);
  }
}

template <typename Bytes, int n>
[[gnu::always_inline]] inline void take_best(const Column<Bytes, n>& sums, const std::uint8_t* costs,
                                             const BestRow& best, int x) {
  const Bytes lowest = sums.spread_least();
  int disparity = 0;
  for (int j = n - 1; j >= 0; --j) {
    const auto equal = equal_lanes(sums.part[j], lowest);
    disparity = equal != 0 ? j * Bytes::kCount + std::countr_zero(equal) : disparity;
  }
  Column<Bytes, n> others;
  for (int j = 0; j < n; ++j) {
    others.part[j] = sums.part[j] | Bytes::load(kThreeOut.data() + kMostLanes + j * Bytes::kCount - disparity);
  }
  std::array<std::uint8_t, n * Bytes::kCount> sum;
  sums.store(sum.data());
  const int before = std::max(disparity - 1, 0), after = std::min(disparity + 1, n * Bytes::kCount - 1);
  best.disparity[x] = static_cast<std::uint8_t>(disparity);
  best.sum[x] = lowest.first();
  best.second[x] = others.spread_least().first();
  best.sum_before[x] = sum[static_cast<std::size_t>(before)];
  best.sum_after[x] = sum[static_cast<std::size_t>(after)];
  best.before[x] = costs[before];
  best.cost[x] = costs[disparity];
  best.after[x] = costs[after];
}

template <typename Bytes, int n>
void along_row(PathRow row) {
  using Pixel = Column<Bytes, n>;
  constexpr std::ptrdiff_t kColumn = n * Bytes::kCount;
  const Bytes small_step = Bytes::all(row.small_step);
  const Pixel out_of_range = Pixel::load(kOutOfRange.data() + kMostLanes - row.disparities);
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    const std::uint8_t* before = row.along_before + x * kColumn;
    const Pixel path = next_on_path(Pixel::load(before), Pixel::neighbours_at(before),
                                    path_costs<Bytes, n>(row.costs + x * kColumn), small_step, row.large_along[x]);
    path.store(row.along + x * kColumn);
    Pixel sum = path;
    sum += Pixel::load(row.from_left + x * kColumn);
    sum += Pixel::load(row.from_right + x * kColumn);
    if (row.sums != nullptr) {
      sum.store(row.sums + x * kColumn);
      continue;
    }
    sum += out_of_range;
    take_best(sum, row.costs + x * kColumn, row.best, x);
  }
}

template <typename Bytes, int n>
void best_row(PathRow row) {
  using Pixel = Column<Bytes, n>;
  const Pixel out_of_range = Pixel::load(kOutOfRange.data() + kMostLanes - row.disparities);
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    Pixel costs = Pixel::load(row.costs + x * n * Bytes::kCount);
    costs += out_of_range;
    take_best(costs, row.costs + x * n * Bytes::kCount, row.best, x);
  }
}

/// Without branches, and no row overlaps another one: the compiler makes vectors of the loops.
inline void judge_row(JudgeRow row) {
  constexpr auto kMatched = static_cast<std::uint8_t>(Match::kMatched);
  const auto code = [](Match match) { return static_cast<std::uint8_t>(match); };
  const BestRow& best = row.best;
#pragma GCC ivdep
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    // The first one, too, where it is 0: what is there is too far for a point, or has come along the paths from the
    // rim, where no other disparity is possible.
    const bool at_end = (best.disparity[x] == 0) | (best.disparity[x] == row.last);
    // Equal costs that are not the largest: those of unlike windows do not grow any further.
    const bool no_texture =
        (best.before[x] == best.cost[x]) & (best.after[x] == best.cost[x]) & (best.cost[x] < row.most);
    const int rise = std::min(best.before[x], best.after[x]) - best.cost[x];
    std::uint8_t state = rise < row.peak ? code(Match::kFlat) : kMatched;
    state = best.second[x] - best.sum[x] < row.uniqueness ? code(Match::kAmbiguous) : state;
    state = best.cost[x] > row.strength ? code(Match::kWeak) : state;
    state = ((row.agrees[x] == 0) | at_end) ? code(Match::kOneSided) : state;
    state = no_texture ? code(Match::kFlat) : state;
    row.match[x] = row.covered[x] == 0 ? code(Match::kUncovered) : state;
  }
  const float per_cost = kSigmaPerShare / static_cast<float>(row.most);
#pragma GCC ivdep
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    // The paths' sums chose it, and are least there; costs alone may be less beside it. They count as one path more.
    const float part =
        sub_pixel(kFineCosts * best.sum_before[x] + best.before[x], kFineCosts * best.sum[x] + best.cost[x],
                  kFineCosts * best.sum_after[x] + best.after[x]);
    const float whole = static_cast<float>(row.first[x] + best.disparity[x]);
    const float sigma = kSigmaOfEqual + per_cost * static_cast<float>(best.cost[x]);
    row.disparity_px[x] = row.match[x] == kMatched ? whole + part : 0.0F;
    row.sigma_px[x] = row.match[x] == kMatched ? sigma : 0.0F;
  }
}

}  // namespace
}  // namespace raybundle
