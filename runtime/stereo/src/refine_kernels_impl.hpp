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
constexpr float kMostShift_px = 1.0F;        // as far as a slope tells
constexpr float kLeastSigma_px = 0.05F;      // what interpolation leaves in images without noise (prove_stereo)
constexpr float kLeastDisparity_px = 0.25F;  // what is matched stays before infinity

inline float over_window(const RefineRows& rows, int x) {
  float sum = 0.0F;
  for (const float* row : rows) sum += row[x];
  return sum;
}

inline void count_row(CountRow row) {
#pragma GCC ivdep
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    const float here = row.disparity_px[x], before = row.disparity_before_px[x], above = row.disparity_above_px[x];
    const float from_before = std::min(before, std::abs(here - before)) > kStep_px ? kStepCount : 0.0F;
    const float from_above = std::min(above, std::abs(here - above)) > kStep_px ? kStepCount : 0.0F;
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
    const float count = over_window(row.counts, x);
    const float number = count < kStepCount ? count : 0.0F;
    const float mean = over_window(row.weighted, x) / std::max(count, 1.0F);
    const float smoothed = number > 0.0F ? mean : row.disparity_px[x];
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
    // The cubic through four pixels, and its slope: that of two neighbours is short of fine texture's by a third.
    const float first = grey(2) - grey(0) / 3.0F - 0.5F * grey(1) - grey(3) / 6.0F;
    const float second = 0.5F * (grey(0) + grey(2)) - grey(1);
    const float third = (grey(3) - grey(0)) / 6.0F + 0.5F * (grey(1) - grey(2));
    const float here = grey(1) + part * (first + part * (second + part * third));
    const float slope_there = first + part * (2.0F * second + part * 3.0F * third);
    const auto left = [at = row.left + x](int k) { return static_cast<float>(at[k]); };
    const float slope_here = (8.0F * (left(1) - left(-1)) - (left(2) - left(-2))) / 12.0F;
    const float weight = row.disparity_px[x] > 0.0F ? 1.0F : 0.0F;
    // The mean of both images' slopes: the second derivatives, of which a step would be short, cancel.
    const float slope = weight * 0.5F * (slope_here + row.gain * slope_there);
    const float difference = weight * (static_cast<float>(row.left[x]) - row.gain * here);
    row.slope[x] = slope;
    row.difference[x] = difference;
    row.slope2[x] = slope * slope;
    row.product[x] = slope * difference;
    row.difference2[x] = difference * difference;
  }
}

inline void refine_row(RefineRow row) {
  constexpr float kPixels = kRefineSide * kRefineSide;
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
    const float variance = std::max(rest * per * (kPixels / (kPixels - 2.0F)), row.noise / 16.0F);
    // What is more than noise is common to the window: unequal blur, brightness or shape. Its pixels do not average.
    const float noise = std::min(variance, row.noise);
    const float common = noise + number * (variance - noise);
    // Noise has slopes, too, which tell nothing: nine tenths of an image's variance, half of that in the mean of both.
    const float told = std::max(slope2 - number * variance / 4.0F, 0.0F);
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
