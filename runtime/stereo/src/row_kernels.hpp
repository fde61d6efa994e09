// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "raybundle/stereo/extent.hpp"
#include "raybundle/stereo/simd.hpp"

// The inner loops of matching, one image row at a time. The disparities of a pixel lie beside each other. A "column" is
// what belongs to one pixel: `lanes` disparities, a multiple of 32, from the pixel's first disparity on.
//
// Rows of the right image are mirrored, so that disparities ascend: the partner of pixel x at disparity d stands at
// index width - 1 - x + d.

namespace raybundle {

/// Costs of a window are counted in quarters of what paths add up.
inline constexpr int kFineCosts = 4;

/// A byte four times, as it is quickly spread over a register.
using RepeatedByte = std::uint32_t;

/// Where a census bit compares: the neighbour's pixel minus the centre's, as an offset into the padded image.
struct CensusRow {
  const std::uint8_t* centre = nullptr;     ///< first pixel of the row
  std::span<const std::ptrdiff_t> offsets;  ///< of the neighbours; bit is set where neighbour >= centre
  int width = 0;                            ///< rounded up to whole lanes: the buffers reach that far
  std::uint8_t* codes = nullptr;            ///< planes of 4 bits each, `plane_stride` apart
  std::ptrdiff_t plane_stride = 0;
};

/// Census bits that differ, weighted, for each pixel and disparity of a row.
struct CensusCostRow {
  int width = 0;
  Extent extent;  ///< pixels whose costs are asked for
  int lanes = 0;
  int planes = 0;
  std::ptrdiff_t plane_stride = 0;
  std::array<std::uint8_t, 16> nibble_costs{};  ///< of the bits in which two nibbles differ
  const std::int16_t* first = nullptr;          ///< first disparity of each pixel
  const std::uint8_t* left_codes = nullptr;
  const std::uint8_t* right_codes = nullptr;   ///< mirrored
  const std::uint8_t* right_limits = nullptr;  ///< mirrored; least cost of a match with that pixel: 0, or the most
  std::uint8_t* costs = nullptr;               ///< width columns
};

/// A sum over rows moves down: one row enters, another one leaves.
template <typename Sum>
struct EnterRow {
  std::ptrdiff_t count = 0;  ///< width × lanes
  const std::uint8_t* enters = nullptr;
  const std::uint8_t* leaves = nullptr;
  Sum* sums = nullptr;
};

/// Sums over rows become sums over windows.
template <typename Sum>
struct WindowRow {
  int width = 0;
  Extent extent;
  int lanes = 0;
  int radius = 0;
  std::uint32_t factor = 0;  ///< of 16-bit sums: cost = sum · factor / 65536
  const Sum* sums = nullptr;
  Sum* window = nullptr;          ///< one column, of 16-bit sums
  std::uint8_t* costs = nullptr;  ///< width columns
};

/// Sums over the pixels of a column of a window, which a row enters or leaves: squared differences, or what a
/// correlation needs.
struct ProductRow {
  int width = 0;
  int lanes = 0;
  bool enters = true;                   ///< else it leaves
  const std::int16_t* first = nullptr;  ///< first disparity of each pixel
  const std::uint8_t* left = nullptr;
  const std::uint8_t* right = nullptr;  ///< mirrored
  std::int32_t* sums = nullptr;         ///< width columns of each sum, `sum_stride` apart
  std::ptrdiff_t sum_stride = 0;
};

/// Sums of products over windows become costs.
struct ProductCostRow {
  int width = 0;
  Extent extent;
  int lanes = 0;
  int radius = 0;
  float scale = 0.0F;  ///< of a sum of squared differences: cost = scale · sum
  float most = 0.0F;   ///< cost
  const std::int16_t* first = nullptr;
  const std::int32_t* left_sums = nullptr;     ///< of a correlation: grey values over the window of each pixel
  const std::int32_t* left_squares = nullptr;  ///< the same of their squares
  const std::uint8_t* right_limits = nullptr;  ///< mirrored
  const std::int32_t* sums = nullptr;
  std::ptrdiff_t sum_stride = 0;
  std::int32_t* window = nullptr;  ///< one column of each sum
  std::uint8_t* costs = nullptr;   ///< width columns
};

/// What is known of the best disparity of each pixel of a row.
struct BestRow {
  std::uint8_t* disparity = nullptr;   ///< from the pixel's first one on
  std::uint8_t* sum = nullptr;         ///< the least
  std::uint8_t* second = nullptr;      ///< least sum of all disparities but the best and its two neighbours
  std::uint8_t* sum_before = nullptr;  ///< sum at disparity - 1, or at the disparity if it is 0
  std::uint8_t* sum_after = nullptr;   ///< the same at disparity + 1, or at the disparity if it is the last lane
  std::uint8_t* before = nullptr;  ///< cost, before it was gathered, at disparity - 1, or at the disparity if it is 0
  std::uint8_t* cost = nullptr;    ///< the same at the disparity
  std::uint8_t* after = nullptr;   ///< the same at disparity + 1, or at the disparity if it is the last lane
};

/// What becomes of each pixel of a row. Values of Match: as match.hpp has them.
struct JudgeRow {
  Extent extent;
  int last = 0;                                ///< disparity beyond which nothing was searched
  int most = 0;                                ///< the largest cost there is
  int uniqueness = 0, strength = 0, peak = 0;  ///< limits; a peak below -255 takes all
  const std::uint8_t* covered = nullptr;       ///< 0: uncovered
  const std::uint8_t* agrees = nullptr;        ///< 0: the right image disagrees
  const std::int16_t* first = nullptr;         ///< first disparity of each pixel
  BestRow best;
  float* disparity_px = nullptr;
  float* sigma_px = nullptr;  ///< of the disparity, 0 where there is none
  std::uint8_t* match = nullptr;
};

/// Costs of a row, gathered along paths that end in each pixel. A large step of 0 begins a path.
struct PathRow {
  Extent extent;
  int lanes = 0;
  int disparities = 0;                         ///< at most lanes; the others are never best
  std::uint8_t small_step = 0;                 ///< cost of a disparity that changes by one from pixel to pixel
  const RepeatedByte* large_across = nullptr;  ///< cost of one that changes by more, from pixel x - 1 to x; width + 1
  const RepeatedByte* large_along = nullptr;   ///< the same from the row before to this one
  const std::uint8_t* costs = nullptr;         ///< width columns, fine
  std::uint8_t* from_left = nullptr;           ///< width columns: sums of the paths from the left
  std::uint8_t* from_right = nullptr;          ///< the same from the right
  const std::uint8_t* along_before = nullptr;  ///< width columns, a byte around them: the paths to the row before
  std::uint8_t* along = nullptr;               ///< width columns: become those to this row
  std::uint8_t* sums = nullptr;  ///< width columns for the sums of all paths, or nullptr: the best is taken
  BestRow best;
};

/// The window whose grey values refine a disparity.
inline constexpr int kRefineRadius = 2;
inline constexpr int kRefineSide = 2 * kRefineRadius + 1;
using RefineRows = std::array<const float*, kRefineSide>;  ///< rows of a window

/// Of a window that reaches over a step in depth: that many pixels more are counted.
inline constexpr float kStepCount = 64.0F;

/// What counts in a window: matches, and the steps in depth between them. A disparity of 0 is no match.
struct CountRow {
  Extent extent;
  const float* disparity_px = nullptr;
  const float* disparity_before_px = nullptr;  ///< of the pixel to the left
  const float* disparity_above_px = nullptr;
  float* count = nullptr;  ///< becomes 1 for each match, kStepCount more for each step in depth to it
};

/// Sums of kRefineSide neighbours in a row; kRefineRadius zeros lie on both sides of what is added.
struct AcrossRow {
  Extent extent;
  const float* values = nullptr;
  float* sums = nullptr;
};

/// Both images where each pixel's smoothed disparity takes it: how their grey values differ, and how they change.
struct DifferenceRow {
  Extent extent;
  int width = 0;
  float gain = 1.0F;                    ///< of the left image over the right one
  float noise = 0.0F;                   ///< variance of a grey value
  const std::uint8_t* left = nullptr;   ///< two pixels around it may be read
  const std::uint8_t* right = nullptr;  ///< one pixel around it may be read
  const float* disparity_px = nullptr;  ///< as found
  RefineRows counts{}, weighted{};      ///< sums across
  std::int32_t* column = nullptr;       ///< becomes that of the pixel in the right image
  std::uint32_t* four = nullptr;        ///< becomes its grey value, after that of the one before, before those of two
  float* number = nullptr;       ///< becomes that of matches in the window, 0 where it reaches over a step in depth
  float* smoothed_px = nullptr;  ///< becomes the mean disparity of the window, or what was found
  /// Become the slope [1/px], the difference left minus right, and their products; 0 where there is no match.
  float *slope = nullptr, *difference = nullptr;
  float *slope2 = nullptr, *product = nullptr, *difference2 = nullptr;
};

/// The step of a disparity that makes both images most alike, and its sigma.
struct RefineRow {
  Extent extent;
  float gain = 1.0F;   ///< of the left image over the right one
  float noise = 0.0F;  ///< variance of a grey value
  const float* number = nullptr;
  const float* smoothed_px = nullptr;
  RefineRows slope{}, difference{}, slope2{}, product{}, difference2{};  ///< sums across
  float* disparity_px = nullptr;                                         ///< as found, becomes refined
  float* sigma_px = nullptr;  ///< as the paths left it, becomes that of the disparity
};

/// What a loop works on comes by value where its bytes could be taken for parts of it.
struct RowKernels {
  void (*census)(const CensusRow& row);
  void (*census_costs)(const CensusCostRow& row);
  void (*enter)(EnterRow<std::uint8_t> row);
  void (*enter_wide)(const EnterRow<std::uint16_t>& row);
  void (*window)(const WindowRow<std::uint8_t>& row);
  void (*window_wide)(const WindowRow<std::uint16_t>& row);
  void (*squares)(const ProductRow& row);
  void (*correlation)(const ProductRow& row);
  void (*square_costs)(const ProductCostRow& row);
  void (*correlation_costs)(const ProductCostRow& row);
  /// Paths from the left and from the right.
  void (*across)(const PathRow& row);
  /// Adds the paths from the row before to those in from_left and from_right.
  void (*along)(const PathRow& row);
  /// Takes the best disparity from the costs alone.
  void (*best)(const PathRow& row);
  void (*judge)(JudgeRow row);
  void (*count)(CountRow row);
  void (*across_window)(AcrossRow row);
  void (*difference)(DifferenceRow row);
  void (*refine)(RefineRow row);
};

const RowKernels& row_kernels(Simd simd);

}  // namespace raybundle
