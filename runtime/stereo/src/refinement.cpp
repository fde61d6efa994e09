// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "refinement.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr int kGainRows = 8;       // every so many rows tell the gain
constexpr float kMostGain = 4.0F;  // of one image over the other; what is more is not believed

/// Mean and variance of grey values.
struct Spread {
  std::int64_t number = 0, sum = 0, sum2 = 0;

  void add(int grey) {
    ++number;
    sum += grey;
    sum2 += grey * grey;
  }
  double variance_times_number2() const { return static_cast<double>(number * sum2 - sum * sum); }
};

}  // namespace

Refinement::Refinement(ImageSize size, double noise_grey, const RowKernels& kernels)
    : size_(size),
      noise_(static_cast<float>(noise_grey * noise_grey)),
      kernels_(kernels),
      left_(size, 2),
      right_(size, 1),
      no_sums_(size.width, 1),
      no_disparities_(size.width, 1),
      number_(size.width),
      smoothed_px_(size.width),
      count_(size.width),
      weighted_(size.width),
      slope_(size.width),
      difference_(size.width),
      slope2_(size.width),
      product_(size.width),
      difference2_(size.width),
      column_(static_cast<std::size_t>(size.width)),
      four_(static_cast<std::size_t>(size.width)) {}

void Refinement::add_across(Sum& sum, int v) {
  Rows& values = sum.values;
  extent(v).fill_beyond(values.row(), size_.width, 0.0F);
  const Extent reached = Extent{}.with(extent(v), kRefineRadius, size_.width);
  reached.fill_beyond(sum.across.row(v), size_.width, 0.0F);
  kernels_.across_window({reached, values.row(), sum.across.row(v)});
}

// The rows of a window about row v; those outside of the image add nothing.
RefineRows Refinement::around(Sum& sum, int v) {
  RefineRows rows{};
  for (int k = 0; k < kRefineSide; ++k) {
    const int at = v + k - kRefineRadius;
    rows[static_cast<std::size_t>(k)] = at < 0 || at >= size_.height ? no_sums_.row() : sum.across.row(at);
  }
  return rows;
}

// Of the left image over the right one, as their spread over what is matched tells.
float Refinement::gain(GreyView left, GreyView right, const float* disparity_px) const {
  Spread of_left, of_right;
  for (int v = 0; v < size_.height; v += kGainRows) {
    for (int x = extent(v).begin; x < extent(v).end; ++x) {
      const float disparity = disparity_px[first(v) + x];
      if (!(disparity > 0)) continue;
      of_left.add(left.at(x, v));
      of_right.add(right.at(std::max(x - static_cast<int>(std::lround(disparity)), 0), v));
    }
  }
  const double a = of_left.variance_times_number2(), b = of_right.variance_times_number2();
  if (!(a > 0 && b > 0)) return 1.0F;
  return std::clamp(static_cast<float>(std::sqrt(a / b)), 1.0F / kMostGain, kMostGain);
}

void Refinement::count(int v, const float* disparity_px) {
  const float* here = disparity_px + first(v);
  float* weighted = weighted_.values.row();
  std::copy_n(here, size_.width, weighted);  // with zeros before it
  const float* above = v > 0 ? here - size_.width : no_disparities_.row();
  kernels_.count({extent(v), weighted, weighted - 1, above, count_.values.row()});
  add_across(count_, v);
  add_across(weighted_, v);
}

void Refinement::differ(int v, float gain, const float* disparity_px) {
  DifferenceRow row;
  row.extent = extent(v);
  row.width = size_.width;
  row.gain = gain;
  row.noise = noise_;
  row.left = left_.row(v);
  row.right = right_.row(v);
  row.disparity_px = disparity_px + first(v);
  row.counts = around(count_, v);
  row.weighted = around(weighted_, v);
  row.column = column_.data();
  row.four = four_.data();
  row.number = number_.row(v);
  row.smoothed_px = smoothed_px_.row(v);
  row.slope = slope_.values.row();
  row.difference = difference_.values.row();
  row.slope2 = slope2_.values.row();
  row.product = product_.values.row();
  row.difference2 = difference2_.values.row();
  kernels_.difference(row);
  for (Sum* sum : {&slope_, &difference_, &slope2_, &product_, &difference2_}) add_across(*sum, v);
}

void Refinement::refine(int v, float gain, float* disparity_px, float* sigma_px) {
  RefineRow row;
  row.extent = extent(v);
  row.gain = gain;
  row.noise = noise_;
  row.number = number_.row(v);
  row.smoothed_px = smoothed_px_.row(v);
  row.slope = around(slope_, v);
  row.difference = around(difference_, v);
  row.slope2 = around(slope2_, v);
  row.product = around(product_, v);
  row.difference2 = around(difference2_, v);
  row.disparity_px = disparity_px + first(v);
  row.sigma_px = sigma_px + first(v);
  kernels_.refine(row);
}

// Each stage needs the rows of a window of the one before: they follow each other at that distance.
void Refinement::run(GreyView left, GreyView right, std::span<const Extent> extents, const std::uint8_t* right_covered,
                     float* disparity_px, float* sigma_px) {
  extents_ = extents;
  left_.fill(left, false);
  right_.fill(right, false);
  for (int v = 0; v < size_.height; ++v) {
    left_.repeat_beyond(v, extent(v));
    right_.repeat_beyond(v, Extent::of(right_covered != nullptr ? right_covered + first(v) : nullptr, size_.width));
  }
  const float of_left = gain(left, right, disparity_px);
  for (int v = 0; v < size_.height + 2 * kRefineRadius; ++v) {
    if (v < size_.height) count(v, disparity_px);
    const int differing = v - kRefineRadius, refined = differing - kRefineRadius;
    if (differing >= 0 && differing < size_.height) differ(differing, of_left, disparity_px);
    if (refined >= 0) refine(refined, of_left, disparity_px, sigma_px);
  }
}

}  // namespace raybundle
