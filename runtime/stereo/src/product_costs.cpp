// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "product_costs.hpp"

#include <algorithm>

#include "census_costs.hpp"

namespace raybundle {
namespace {

constexpr int kMost = 240;
constexpr float kMostRms_grey = 32.0F;  // root mean square of the differences that cost the most

}  // namespace

ProductCosts::ProductCosts(ImageSize size, int lanes, const MatchOptions& options, const RowKernels& kernels)
    : size_(size),
      lanes_(lanes),
      radius_(options.window_px / 2),
      correlation_(options.cost == MatchCost::kZncc),
      kernels_(kernels),
      limits_(size.width, lanes, kMost) {
  const std::size_t columns = static_cast<std::size_t>(size.width) * lanes;
  const std::size_t planes = correlation_ ? 3 : 1;
  right_.assign(static_cast<std::size_t>(options.window_px + 1),
                std::vector<std::uint8_t>(RightLimits::mirrored_length(size.width, lanes)));
  sums_.resize(planes * columns);
  window_.resize(planes * static_cast<std::size_t>(lanes));
  costs_.resize(columns);
  for (auto* row : {&left_columns_, &left_column_squares_, &left_sums_, &left_squares_}) {
    row->resize(static_cast<std::size_t>(size.width));
  }
}

int ProductCosts::most() const { return kMost; }

void ProductCosts::begin(const SearchedPair& pair, std::span<const Extent> extents) {
  pair_ = pair;
  extents_ = extents;
  for (auto* sums : {&sums_, &left_columns_, &left_column_squares_}) std::fill(sums->begin(), sums->end(), 0);
}

// Rows outside of the image are as the nearest one in it.
void ProductCosts::move(int v, bool enters) {
  v = std::clamp(v, 0, size_.height - 1);
  const std::uint8_t* left = pair_.left.row(v);
  std::vector<std::uint8_t>& mirrored = right_[static_cast<std::size_t>(v) % right_.size()];
  if (enters) {
    const std::uint8_t* right = pair_.right.row(v);
    const auto end = std::reverse_copy(right, right + size_.width, mirrored.begin());
    std::fill(end, mirrored.end(), right[0]);
  }
  const ProductRow row{size_.width, lanes_,          enters,       pair_.first.row(v),
                       left,        mirrored.data(), sums_.data(), static_cast<std::ptrdiff_t>(size_.width) * lanes_};
  (correlation_ ? kernels_.correlation : kernels_.squares)(row);
  const int sign = enters ? 1 : -1;
  for (std::size_t x = 0; x < left_columns_.size(); ++x) {
    left_columns_[x] += sign * left[x];
    left_column_squares_[x] += sign * left[x] * left[x];
  }
}

void ProductCosts::sum_left(int v) {
  limits_.fill(v, pair_.right_covered);
  const int last = size_.width - 1;
  std::int32_t sum = 0, squares = 0;
  const auto add = [&](int x, int sign) {
    sum += sign * left_columns_[static_cast<std::size_t>(std::clamp(x, 0, last))];
    squares += sign * left_column_squares_[static_cast<std::size_t>(std::clamp(x, 0, last))];
  };
  for (int x = -radius_; x < radius_; ++x) add(x, 1);
  for (int x = 0; x <= last; ++x) {
    add(x + radius_, 1);
    left_sums_[static_cast<std::size_t>(x)] = sum;
    left_squares_[static_cast<std::size_t>(x)] = squares;
    add(x - radius_, -1);
  }
}

const std::uint8_t* ProductCosts::row(int v) {
  if (v == 0) {
    for (int k = -radius_; k <= radius_; ++k) move(k, true);
  } else {
    move(v - radius_ - 1, false);
    move(v + radius_, true);
  }
  sum_left(v);
  const auto pixels = static_cast<float>((2 * radius_ + 1) * (2 * radius_ + 1));
  const ProductCostRow costs{size_.width,
                             extents_[static_cast<std::size_t>(v)],
                             lanes_,
                             radius_,
                             kMost / (pixels * kMostRms_grey * kMostRms_grey),
                             kMost,
                             pair_.first.row(v),
                             left_sums_.data(),
                             left_squares_.data(),
                             limits_.mirrored(),
                             sums_.data(),
                             static_cast<std::ptrdiff_t>(size_.width) * lanes_,
                             window_.data(),
                             costs_.data()};
  (correlation_ ? kernels_.correlation_costs : kernels_.square_costs)(costs);
  return costs_.data();
}

std::unique_ptr<MatchCosts> match_costs(ImageSize size, int lanes, const MatchOptions& options,
                                        const RowKernels& kernels) {
  if (options.cost == MatchCost::kCensus) return std::make_unique<CensusCosts>(size, lanes, options, kernels);
  return std::make_unique<ProductCosts>(size, lanes, options, kernels);
}

}  // namespace raybundle
