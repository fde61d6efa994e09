// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "raybundle/stereo/simd.hpp"

namespace raybundle {

/// How unlike two windows are.
///
/// census: the order of each pixel and its neighbours, whatever brightness and contrast of the images.
/// ssd: squared differences of grey values, for cameras that see the same brightness.
/// zncc: correlation after mean and contrast of both windows are taken out.
enum class MatchCost : unsigned char { kCensus, kSsd, kZncc };
inline constexpr std::array<MatchCost, 3> kMatchCosts{MatchCost::kCensus, MatchCost::kSsd, MatchCost::kZncc};

/// census, ssd or zncc.
std::string_view match_cost_name(MatchCost cost);
std::optional<MatchCost> match_cost_named(std::string_view name);

/// Which neighbours a census compares with the centre: offsets (x, y) [px].
using CensusMask = std::vector<std::array<int, 2>>;

/// All neighbours in a square of an odd side, at most 11 [px].
CensusMask dense_census(int side_px);

/// Every other neighbour in a square of an odd side, in the pattern of a chessboard: half the bits, nearly the quality.
CensusMask sparse_census(int side_px);

/// How to match. What an option is, is also what it is when it is left out.
struct MatchOptions {
  /// Searched, 1 to 256; with coarse levels as many that the coarsest one, which halves them and adds two for each
  /// level, has no more. Up to the next of 32, 64, 96, 128, 192
  /// and 256 they compete along paths, but are never taken.
  int disparities = 64;
  int least_disparity = 0;  ///< the first of them [px], >= 0, itself never a match: for scenes that are never far
  MatchCost cost = MatchCost::kCensus;
  CensusMask mask = dense_census(3);
  int window_px = 5;         ///< side of the square over which costs are averaged: odd, 1 to 15
  int paths = 3;             ///< semi-global: costs are gathered along 3 (from left, right and above) or 4 paths, or 0
  double small_step = 0.25;  ///< cost of a disparity that changes by one along a path, as a share of the largest cost
  double large_step = 1.4;   ///< cost of one that changes by more
  double edge_grey = 20.0;   ///< step of grey values that halves the cost of a large step: depth often changes there
  /// Sizes, each half of the one before, on which the search begins; the next one searches 64 disparities around it.
  /// 0: all disparities of the whole image. Faster for many disparities; thin things may get lost.
  int coarse_levels = 0;

  double uniqueness =
      0.12;  ///< least lead over the second best that is not beside the best, as a share of the largest sum
  double strength = 1.0;  ///< largest cost of a match, as a share of the largest cost there is
  double peak = 0.0;      ///< least rise of the cost to the lower neighbour, as a share of the largest cost there is
  int left_right_px = 1;  ///< most disagreement of both directions; negative: not checked
  int least_region_px = 100;  ///< regions of smooth disparity with fewer pixels are left out; 0 keeps all
  bool refine = true;         ///< by grey values what the costs found; costs a fifth of the time
  double noise_grey = 1.0;    ///< standard deviation of a grey value of the rectified images
  Simd simd = best_simd();
};

/// The census that tells so many disparities apart best: of the eight neighbours up to 128. Beyond, images are so large
/// that neighbours differ by noise more than by what is seen: the sparse one of 9x9 px.
CensusMask census_for(int disparities);

/// Coarse levels that make a search of so many disparities fast: none up to 250, which can be searched as a whole and
/// then are told apart best.
int coarse_levels_for(int disparities);

}  // namespace raybundle
