// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "row_kernels.hpp"

// Disparities refined by grey values (refinement.hpp). Loops for the compiler to make vectors of: single operations
// that round the same way on every machine, in one order.

namespace raybundle {
namespace {

constexpr float kStep_px = 1.5F;             // between neighbours: more is a step in depth
constexpr float kFarFromMean_px = 1.0F;      // what is as far from its window's mean lies beside a step
constexpr float kMostShift_px = 0.5F;        // more is another match, which the paths did not choose
constexpr float kLeastSigma_px = 0.05F;      // what interpolation leaves in images without noise (prove_stereo)
constexpr float kLeastDisparity_px = 0.25F;  // what is matched stays before infinity

constexpr float kSlopeNoise = 130.0F / 144.0F;  // of the left image's slope, from four neighbours, over a pixel's

/// The cubic through four pixels, at `part` from the second to the third: their weights, and those of its slope. The
/// slope of two neighbours would be short of fine texture's by a third.
struct Cubic {
  float weight[4], slope[4];  // plain arrays: the loops become vectors

  explicit Cubic(float part) {
    const float square = part * part, cube = part * square;
    weight[0] = 0.5F * square - part / 3.0F - cube / 6.0F;
    weight[1] = 1.0F - 0.5F * part - square + 0.5F * cube;
    weight[2] = part + 0.5F * square - 0.5F * cube;
    weight[3] = (cube - part) / 6.0F;
    slope[0] = part - 1.0F / 3.0F - 0.5F * square;
    slope[1] = 1.5F * square - 2.0F * part - 0.5F;
    slope[2] = 1.0F + part - 1.5F * square;
    slope[3] = 0.5F * square - 1.0F / 6.0F;
  }
  /// Covariance of value and slope, and the slope's variance, of pixels whose noise has variance 1.
  float weight_by_slope() const {
    return weight[0] * slope[0] + weight[1] * slope[1] + weight[2] * slope[2] + weight[3] * slope[3];
  }
  float slope_squared() const {
    return slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2] + slope[3] * slope[3];
  }
};

inline float over_window(const RefineRows& rows, int x) {
  float sum = 0.0F;
  for (const float* row : rows) sum += row[x];
  return sum;
}

inline void count_row(CountRow row) {
#pragma GCC ivdep
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    const float here = row.disparity_px[x], before = row.disparity_before_px[x], above = row.disparity_above_px[x];
    const bool step_before = (before > 0.0F) & (std::abs(here - before) > kStep_px);
    const bool step_above = (above > 0.0F) & (std::abs(here - above) > kStep_px);
    const float from_before = step_before ? kStepCount : 0.0F, from_above = step_above ? kStepCount : 0.0F;
    const float match = here > 0.0F ? 1.0F : 0.0F;
    row.count[x] = match * (1.0F + from_before + from_above);
  }
}

inline void across_window_row(AcrossRow row) {
#pragma GCC ivdep
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    float sum = 0.0F;
    for (int k = -kRefineRadius; k <= kRefineRadius; ++k) sum += row.values[x + k];
    row.sums[x] = sum;
  }
}

inline void difference_row(DifferenceRow row) {
#pragma GCC ivdep
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    const float count = over_window(row.counts, x), found = row.disparity_px[x];
    const float mean = over_window(row.weighted, x) / std::max(count, 1.0F);
    // Steps lie between neighbours, or, with a gap between, show in the mean.
    const bool smooth = (count < kStepCount) & ((found == 0.0F) | (std::abs(mean - found) < kFarFromMean_px));
    const float number = smooth ? count : 0.0F;
    const float smoothed = number > 0.0F ? mean : found;
    row.number[x] = number;
    row.smoothed_px[x] = smoothed;
    row.column[x] = std::clamp(static_cast<std::int32_t>(static_cast<float>(x) - smoothed), 0, row.width - 2);
  }
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    const std::uint8_t* at = row.right + row.column[x] - 1;
    row.four[x] = at[0] | at[1] << 8U | at[2] << 16U | static_cast<std::uint32_t>(at[3]) << 24U;
  }
#pragma GCC ivdep
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    const float position = static_cast<float>(x) - row.smoothed_px[x];
    const float part = std::min(std::max(position - static_cast<float>(row.column[x]), 0.0F), 1.0F);
    const auto grey = [four = row.four[x]](int k) { return static_cast<float>(four >> (8 * k) & 255U); };
    const Cubic cubic(part);
    const float here =
        cubic.weight[0] * grey(0) + cubic.weight[1] * grey(1) + cubic.weight[2] * grey(2) + cubic.weight[3] * grey(3);
    const float slope_there =
        cubic.slope[0] * grey(0) + cubic.slope[1] * grey(1) + cubic.slope[2] * grey(2) + cubic.slope[3] * grey(3);
    const auto left = [at = row.left + x](int k) { return static_cast<float>(at[k]); };
    const float slope_here = (8.0F * (left(1) - left(-1)) - (left(2) - left(-2))) / 12.0F;
    const float weight = row.disparity_px[x] > 0.0F ? 1.0F : 0.0F;
    // The mean of both images' slopes: the second derivatives, of which a step would be short, cancel.
    const float slope = weight * 0.5F * (slope_here + row.gain * slope_there);
    const float difference = weight * (static_cast<float>(row.left[x]) - row.gain * here);
    row.slope[x] = slope;
    row.difference[x] = difference;
    row.slope2[x] = slope * slope;
    // The right image's noise is in slope and difference, and would pull to half pixels.
    row.product[x] = slope * difference + weight * 0.5F * row.gain * row.gain * row.noise * cubic.weight_by_slope();
    row.difference2[x] = difference * difference;
  }
}

inline void refine_row(RefineRow row) {
  constexpr float kPixels = kRefineSide * kRefineSide;
  const float gain2 = row.gain * row.gain, noise_of_difference = row.noise * (1.0F + gain2);
#pragma GCC ivdep
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    const float number = row.number[x], per = 1.0F / std::max(number, 1.0F);
    const float slope = over_window(row.slope, x), difference = over_window(row.difference, x);
    // About their means: both cameras' images may differ by an offset.
    const float slope2 = std::max(over_window(row.slope2, x) - slope * slope * per, 0.0F);
    const float product = over_window(row.product, x) - slope * difference * per;
    const float difference2 = over_window(row.difference2, x) - difference * difference * per;
    const float full = -product / std::max(slope2, 1e-3F);
    const float shift = std::min(std::max(full, -kMostShift_px), kMostShift_px);
    const float rest = difference2 + shift * (2.0F * product + shift * slope2);
    const float variance = std::max(rest / std::max(number - 2.0F, 1.0F), noise_of_difference / 16.0F);
    // What is more than noise is common to the window: unequal blur, brightness or shape. Its pixels do not average.
    const float noise = std::min(variance, noise_of_difference);
    const float common = noise + number * (variance - noise);
    // Noise has slopes, too, which tell nothing: a quarter of those of both images, in the mean of both.
    const float position = static_cast<float>(x) - row.smoothed_px[x];
    const Cubic cubic(position - std::floor(position));
    const float slope_noise = 0.25F * (kSlopeNoise + gain2 * cubic.slope_squared()) / (1.0F + gain2);
    const float told = std::max(slope2 - number * variance * slope_noise, 0.0F);
    // Two measurements of one disparity, of variances `before` and common / told.
    const float before = row.sigma_px[x] * row.sigma_px[x];
    const float both = 1.0F / (before * told + common);
    const float disparity = row.smoothed_px[x] + before * told * both * shift;
    const float sigma2 = std::max(before * common * both, kLeastSigma_px * kLeastSigma_px);
    const bool tells = (row.disparity_px[x] > 0.0F) & (number >= 0.5F * kPixels);
    row.disparity_px[x] = tells ? std::max(disparity, kLeastDisparity_px) : row.disparity_px[x];
    row.sigma_px[x] = tells ? std::sqrt(sigma2) : row.sigma_px[x];
  }
}

}  // namespace
}  // namespace raybundle
