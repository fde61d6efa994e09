// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "raybundle/stereo/simd.hpp"

// The inner loops of matching, one image row at a time. All numbers are bytes; the disparities of a pixel lie beside
// each other. A "column" is what belongs to one pixel: `lanes` disparities, a multiple of 32.

namespace raybundle {

/// Where a census bit compares: the neighbour's pixel minus the centre's, as an offset into the padded image.
struct CensusRow {
  const std::uint8_t* centre = nullptr;     ///< first pixel of the row
  std::span<const std::ptrdiff_t> offsets;  ///< of the neighbours; bit is set where neighbour >= centre
  int width = 0;                            ///< rounded up to whole lanes: the buffers reach that far
  std::uint8_t* codes = nullptr;            ///< planes of 4 bits each, `plane_stride` apart
  std::ptrdiff_t plane_stride = 0;
};

/// Matching costs of a row: for each pixel and disparity, the census bits that differ, weighted.
struct CensusCostRow {
  int width = 0;
  int lanes = 0;
  int planes = 0;
  std::ptrdiff_t plane_stride = 0;
  std::array<std::uint8_t, 16> nibble_costs{};  ///< of the bits in which two nibbles differ
  const std::uint8_t* left_codes = nullptr;
  /// Mirrored, so that disparities ascend: of pixel x and disparity d at index width - 1 - x + d.
  const std::uint8_t* right_codes = nullptr;
  const std::uint8_t* right_limits = nullptr;  ///< mirrored; least cost of a match with that pixel: 0, or the most
  std::uint8_t* costs = nullptr;               ///< width columns
};

/// Costs averaged over 3 × 3 pixels with the weights 1 2 1 in rows and columns.
struct SmoothRow {
  int width = 0;
  int lanes = 0;
  const std::uint8_t* from[3] = {};  ///< costs of the rows above, here and below
  std::uint8_t* costs = nullptr;
};

/// What is known of the best disparity of each pixel of a row.
struct BestRow {
  std::uint8_t* disparity = nullptr;
  std::uint8_t* sum = nullptr;     ///< the least
  std::uint8_t* second = nullptr;  ///< least sum of all disparities but the best and its two neighbours
  std::uint8_t* before = nullptr;  ///< cost, before it was gathered, at disparity - 1; 255 where there is none
  std::uint8_t* cost = nullptr;    ///< the same at the disparity
  std::uint8_t* after = nullptr;   ///< the same at disparity + 1; 255 where there is none
};

/// Costs of a row, gathered along paths that end in each pixel.
struct PathRow {
  int width = 0;
  int lanes = 0;
  int disparities = 0;                  ///< at most lanes; the others are never best
  int row = 0;                          ///< of the image, from 0
  std::uint8_t small_step = 0;          ///< cost of a disparity that changes by one from pixel to pixel
  std::uint8_t large_step = 0;          ///< cost of one that changes by more
  const std::uint8_t* costs = nullptr;  ///< width columns
  std::uint8_t* sums = nullptr;         ///< width columns, 32 bytes of 255 before and behind
  std::uint8_t* above[3] = {};          ///< state of the paths from above: width columns, each followed by 32 × 255,
                                        ///< and 32 × 255 before the first
  BestRow best;
};

struct RowKernels {
  void (*census)(const CensusRow& row);
  void (*census_costs)(const CensusCostRow& row);
  void (*smooth)(const SmoothRow& row);
  /// Adds up the paths from the left, from above (straight and along both diagonals) and from the right, and takes the
  /// best disparity of each pixel.
  void (*paths)(const PathRow& row);
  /// Takes the best disparity from the costs alone.
  void (*best)(const PathRow& row);
};

const RowKernels& row_kernels(Simd simd);

}  // namespace raybundle
