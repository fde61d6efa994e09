// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "raybundle/stereo/simd.hpp"

namespace raybundle {

/// Which neighbours a census compares with the centre: offsets (x, y) [px].
using CensusMask = std::vector<std::array<int, 2>>;

/// All neighbours in a square of an odd side, at most 11 [px].
CensusMask dense_census(int side_px);

/// Every other neighbour in a square of an odd side, in the pattern of a chessboard: half the bits, nearly the quality.
CensusMask sparse_census(int side_px);

/// How to match. What an option is, is also what it is when it is left out.
struct MatchOptions {
  int disparities = 64;     ///< searched, 1 to 256
  int least_disparity = 0;  ///< the first of them [px], >= 0: for scenes that are never far
  CensusMask mask = dense_census(5);
  int window_px = 3;        ///< side of the square over which costs are averaged: 1, or 3 with weights 1 2 1
  bool paths = true;        ///< semi-global: costs are gathered along five paths
  double small_step = 0.2;  ///< cost of a disparity that changes by one along a path, as a share of the largest cost
  double large_step = 0.8;  ///< cost of one that changes by more

  double uniqueness =
      0.12;  ///< least lead over the second best that is not beside the best, as a share of the largest sum
  double strength = 1.0;  ///< largest cost of a match, as a share of the largest cost there is
  double peak = 0.0;      ///< least rise of the cost to the lower neighbour, as a share of the largest cost there is
  int left_right_px = 1;  ///< most disagreement of both directions; negative: not checked
  int least_region_px = 100;  ///< regions of smooth disparity with fewer pixels are left out; 0 keeps all
  Simd simd = best_simd();
};

}  // namespace raybundle
