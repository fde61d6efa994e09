// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "census_costs.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace raybundle {
namespace {

// Costs are scaled to about this, so that sums along paths that deserve it stay below 255 and fractions are kept.
constexpr int kScale = 48;

int radius_of(const CensusMask& mask) {
  int radius = 0;
  for (const auto& [x, y] : mask) radius = std::max({radius, std::abs(x), std::abs(y)});
  return radius;
}

int cost_of_bit(const CensusMask& mask) { return std::max(1, kScale / static_cast<int>(mask.size())); }

}  // namespace

CensusCosts::CensusCosts(ImageSize size, int lanes, const MatchOptions& options, const RowKernels& kernels)
    : size_(size),
      lanes_(lanes),
      planes_((static_cast<int>(options.mask.size()) + 3) / 4),
      least_disparity_(options.least_disparity),
      window_px_(options.window_px),
      most_(cost_of_bit(options.mask) * static_cast<int>(options.mask.size())),
      plane_stride_(size.width + 2 * PaddedImage::kLanes + options.least_disparity + lanes),
      kernels_(kernels),
      left_(size, radius_of(options.mask)),
      right_(size, radius_of(options.mask)) {
  for (const auto& [x, y] : options.mask) {
    left_offsets_.push_back(y * left_.stride() + x);
    right_offsets_.push_back(y * right_.stride() - x);
  }
  for (unsigned nibble = 0; nibble < 16; ++nibble) {
    nibble_costs_[nibble] = static_cast<std::uint8_t>(cost_of_bit(options.mask) * std::popcount(nibble));
  }
  left_codes_.resize(static_cast<std::size_t>(plane_stride_ * planes_));
  right_codes_.resize(static_cast<std::size_t>(plane_stride_ * planes_));
  right_limits_.assign(static_cast<std::size_t>(plane_stride_), static_cast<std::uint8_t>(most_));
  const std::size_t columns = static_cast<std::size_t>(size.width) * lanes;
  for (auto& row : raw_) row.resize(columns);
  smooth_.resize(columns);
}

void CensusCosts::begin(GreyView left, GreyView right) {
  left_.fill(left, false);
  right_.fill(right, true);
}

void CensusCosts::fill_raw(int v, const std::uint8_t* right_covered) {
  kernels_.census({left_.row(v), left_offsets_, size_.width, left_codes_.data(), plane_stride_});
  kernels_.census({right_.row(v), right_offsets_, size_.width, right_codes_.data(), plane_stride_});
  for (int x = 0; x < size_.width; ++x) {
    const bool covered =
        right_covered == nullptr || right_covered[static_cast<std::ptrdiff_t>(v) * size_.width + x] != 0;
    right_limits_[static_cast<std::size_t>(size_.width - 1 - x)] = static_cast<std::uint8_t>(covered ? 0 : most_);
  }
  kernels_.census_costs({size_.width, lanes_, planes_, plane_stride_, nibble_costs_, left_codes_.data(),
                         right_codes_.data() + least_disparity_, right_limits_.data() + least_disparity_, raw(v)});
}

const std::uint8_t* CensusCosts::row(int v, const std::uint8_t* right_covered) {
  if (window_px_ == 1) {
    fill_raw(v, right_covered);
    return raw(v);
  }
  if (v == 0) fill_raw(0, right_covered);
  const bool last = v + 1 == size_.height;
  if (!last) fill_raw(v + 1, right_covered);
  kernels_.smooth({size_.width, lanes_, {raw(v == 0 ? 0 : v - 1), raw(v), raw(last ? v : v + 1)}, smooth_.data()});
  return smooth_.data();
}

}  // namespace raybundle
