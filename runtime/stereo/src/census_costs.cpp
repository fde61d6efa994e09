// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "census_costs.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "byte_lanes.hpp"

namespace raybundle {
namespace {

constexpr int kMostByte = 255;
constexpr int kMostWide = 240;  // what sums that do not fit into bytes are scaled to

int radius_of(const CensusMask& mask) {
  int radius = 0;
  for (const auto& [x, y] : mask) radius = std::max({radius, std::abs(x), std::abs(y)});
  return radius;
}

// Weight of a bit, so that fractions are kept as far as bytes can hold them.
int cost_of_bit(const MatchOptions& options) {
  const int bits = static_cast<int>(options.mask.size()) * options.window_px * options.window_px;
  return std::max(1, kMostByte / bits);
}

}  // namespace

CensusCosts::CensusCosts(ImageSize size, int lanes, const MatchOptions& options, const RowKernels& kernels)
    : size_(size),
      lanes_(lanes),
      planes_((static_cast<int>(options.mask.size()) + 3) / 4),
      radius_(options.window_px / 2),
      most_bits_(cost_of_bit(options) * static_cast<int>(options.mask.size())),
      wide_(most_bits_ * options.window_px * options.window_px > kMostByte),
      most_(wide_ ? kMostWide : most_bits_ * options.window_px * options.window_px),
      plane_stride_(static_cast<std::ptrdiff_t>(RightLimits::mirrored_length(size.width, lanes)) + kLanes),
      kernels_(kernels),
      left_(size, radius_of(options.mask)),
      right_(size, radius_of(options.mask)),
      limits_(size.width, lanes, most_bits_) {
  for (const auto& [x, y] : options.mask) {
    left_offsets_.push_back(y * left_.stride() + x);
    right_offsets_.push_back(y * right_.stride() - x);
  }
  for (unsigned nibble = 0; nibble < 16; ++nibble) {
    nibble_costs_[nibble] = static_cast<std::uint8_t>(cost_of_bit(options) * std::popcount(nibble));
  }
  left_codes_.resize(static_cast<std::size_t>(plane_stride_ * planes_));
  right_codes_.resize(static_cast<std::size_t>(plane_stride_ * planes_));
  const std::size_t columns = static_cast<std::size_t>(size.width) * lanes;
  bits_.assign(static_cast<std::size_t>(options.window_px + 1), Columns(columns));
  if (radius_ == 0) return;
  no_bits_.resize(columns);
  costs_.resize(columns);
  if (wide_) {
    wide_sums_.resize(columns);
    wide_window_.resize(static_cast<std::size_t>(lanes));
  } else {
    sums_.resize(columns);
  }
}

void CensusCosts::begin(const SearchedPair& pair, std::span<const Extent> extents) {
  pair_ = pair;
  extents_ = extents;
  left_.fill(pair.left, false);
  right_.fill(pair.right, true);
  std::fill(sums_.begin(), sums_.end(), std::uint8_t{0});
  std::fill(wide_sums_.begin(), wide_sums_.end(), std::uint16_t{0});
}

// The pixels of row v that a window reaches. Beside them bits stay those of an older row, in sums that nobody asks for.
Extent CensusCosts::windows_over(int v) const {
  Extent extent;
  for (int k = std::max(v - radius_, 0); k <= std::min(v + radius_, size_.height - 1); ++k) {
    extent = extent.with(extents_[static_cast<std::size_t>(k)], radius_, size_.width);
  }
  return extent;
}

void CensusCosts::fill_bits(int v) {
  kernels_.census({left_.row(v), left_offsets_, size_.width, left_codes_.data(), plane_stride_});
  kernels_.census({right_.row(v), right_offsets_, size_.width, right_codes_.data(), plane_stride_});
  limits_.fill(v, pair_.right_covered);
  kernels_.census_costs({size_.width, windows_over(v), lanes_, planes_, plane_stride_, nibble_costs_,
                         pair_.first.row(v), left_codes_.data(), right_codes_.data(), limits_.mirrored(), bits(v)});
}

void CensusCosts::enter(const std::uint8_t* enters, const std::uint8_t* leaves) {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(size_.width) * lanes_;
  if (wide_) {
    kernels_.enter_wide({count, enters, leaves, wide_sums_.data()});
  } else {
    kernels_.enter({count, enters, leaves, sums_.data()});
  }
}

const std::uint8_t* CensusCosts::row(int v) {
  if (radius_ == 0) {
    fill_bits(v);
    return bits(v);
  }
  const int last = size_.height - 1;
  if (v == 0) {  // the rows above the image are as its first one
    fill_bits(0);
    for (int k = 0; k <= radius_; ++k) enter(bits(0), no_bits_.data());
    for (int k = 1; k <= radius_; ++k) {
      if (k <= last) fill_bits(k);
      enter(bits(std::min(k, last)), no_bits_.data());
    }
  } else {
    if (v + radius_ <= last) fill_bits(v + radius_);
    enter(bits(std::min(v + radius_, last)), bits(std::max(v - radius_ - 1, 0)));
  }
  const Extent extent = extents_[static_cast<std::size_t>(v)];
  if (wide_) {
    const auto factor =
        static_cast<std::uint32_t>((kMostWide << 16) / (most_bits_ * (2 * radius_ + 1) * (2 * radius_ + 1)));
    kernels_.window_wide(
        {size_.width, extent, lanes_, radius_, factor, wide_sums_.data(), wide_window_.data(), costs_.data()});
  } else {
    kernels_.window({size_.width, extent, lanes_, radius_, 0, sums_.data(), nullptr, costs_.data()});
  }
  return costs_.data();
}

}  // namespace raybundle
