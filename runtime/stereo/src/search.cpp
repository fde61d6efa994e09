// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "search.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr int kMostLevel = 256;       // above every difference of costs
constexpr std::ptrdiff_t kLine = 64;  // bytes before columns whose neighbours are read: they stay aligned

int lanes_for(int disparities) {
  for (const int lanes : {32, 64, 96, 128, 192}) {
    if (disparities <= lanes) return lanes;
  }
  return 256;
}

}  // namespace

Search::Search(ImageSize size, const MatchOptions& options)
    : options_(options),
      size_(size),
      lanes_(lanes_for(options.disparities)),
      kernels_(row_kernels(options.simd)),
      costs_(match_costs(size, lanes_, options, kernels_)) {
  const int most = costs_->most();
  const double path_most = static_cast<double>(most) / kFineCosts;
  const double small = std::round(options.small_step * path_most);
  small_step_ = static_cast<std::uint8_t>(small);
  for (std::size_t grey = 0; grey < large_steps_.size(); ++grey) {
    const double edge = 1.0 + static_cast<double>(grey) / options.edge_grey;
    const auto large =
        static_cast<std::uint8_t>(std::lround(std::max(small + 1.0, options.large_step * path_most / edge)));
    large_steps_[grey] = 0x01010101U * large;
  }
  uniqueness_limit_ =
      static_cast<int>(std::ceil(options.uniqueness * (options.paths > 0 ? options.paths * path_most : most)));
  strength_limit_ = static_cast<int>(options.strength * most);
  peak_limit_ = options.peak > 0 ? static_cast<int>(std::ceil(options.peak * most)) : -kMostLevel;

  const auto width = static_cast<std::size_t>(size.width);
  extents_.resize(static_cast<std::size_t>(size.height));
  large_across_.resize(width + 1);
  large_along_.resize(width);
  from_left_.resize(width * lanes_);
  from_right_.resize(width * lanes_);
  for (Columns* along : {&along_, &along_before_}) along->resize(kLine + width * lanes_ + 1);
  if (options.paths == 4) {
    all_costs_.resize(width * lanes_ * size.height);
    all_sums_.resize(width * lanes_ * size.height);
  }
  for (Bytes* bytes : {&best_, &least_sum_, &second_, &sum_before_, &sum_after_, &before_, &cost_, &after_, &agrees_})
    bytes->resize(width);
  all_covered_.assign(width, 1);
  right_.resize(width);
}

PathRow Search::path_row(const std::uint8_t* costs, int v) {
  PathRow row;
  row.extent = extent(v);
  row.lanes = lanes_;
  row.disparities = options_.disparities;
  row.small_step = small_step_;
  row.large_across = large_across_.data();
  row.large_along = large_along_.data();
  row.costs = costs;
  row.from_left = from_left_.data();
  row.from_right = from_right_.data();
  row.along_before = along_before_.data() + kLine;
  row.along = along_.data() + kLine;
  row.best = best_row();
  return row;
}

// The large steps to row v: along it, and from the row before it, which is above or below. Where that was not searched,
// or from another disparity on, a path begins.
void Search::steps_of(const SearchedPair& pair, int v, int before) {
  const GreyView left = pair.left;
  const RepeatedByte* steps = large_steps_.data();
  const auto fill = [&](const std::uint8_t* a, const std::uint8_t* b, int count, RepeatedByte* out) {
    for (int x = 0; x < count; ++x) out[x] = steps[std::abs(a[x] - b[x])];
  };
  const auto begin_where = [](const std::int16_t* a, const std::int16_t* b, int count, RepeatedByte* out) {
    for (int x = 0; x < count; ++x) out[x] = a[x] == b[x] ? out[x] : 0;
  };
  const std::uint8_t* here = left.row(v);
  const auto [begin, end] = extent(v);
  fill(here + begin + 1, here + begin, end - begin - 1, large_across_.data() + begin + 1);
  const std::int16_t* first = pair.first.row(v);
  begin_where(first + begin + 1, first + begin, end - begin - 1, large_across_.data() + begin + 1);
  std::fill(large_along_.begin() + begin, large_along_.begin() + end, RepeatedByte{0});
  if (before < 0 || before >= size_.height) return;
  const int from = std::max(begin, extent(before).begin), to = std::min(end, extent(before).end);
  fill(here + from, left.row(before) + from, to - from, large_along_.data() + from);
  begin_where(first + from, pair.first.row(before) + from, to - from, large_along_.data() + from);
}

void Search::gather_down(const SearchedPair& pair, int v) {
  const std::uint8_t* costs = costs_->row(v);
  PathRow row = path_row(costs, v);
  if (options_.paths == 0) return kernels_.best(row);
  steps_of(pair, v, v - 1);
  kernels_.across(row);
  if (options_.paths == 4) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(v) * size_.width * lanes_;
    std::copy_n(costs, size_.width * lanes_, all_costs_.data() + first);
    row.sums = all_sums_.data() + first;
  }
  kernels_.along(row);
  along_.swap(along_before_);
}

void Search::gather_up(const SearchedPair& pair, int v) {
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(v) * size_.width * lanes_;
  PathRow row = path_row(all_costs_.data() + first, v);
  row.from_left = all_sums_.data() + first;
  steps_of(pair, v, v + 1);
  kernels_.along(row);
  along_.swap(along_before_);
}

// Of the left image's pixels that claim a pixel of the right image, the one with the least sum gets it; another one
// agrees with that when its disparity is nearly the same.
void Search::find_agreeing(Extent extent, const std::int16_t* first, const std::uint8_t* right_covered) {
  constexpr std::uint32_t kDisparity = 0xffff;
  std::fill(right_.begin(), right_.end(), ~std::uint32_t{0});
  const std::uint8_t *best = best_.data(), *least_sum = least_sum_.data();
  std::uint32_t* right = right_.data();
  for (int x = extent.begin; x < extent.end; ++x) {
    const int disparity = first[x] + best[x];
    if (disparity > x) continue;
    std::uint32_t& claim = right[x - disparity];
    claim = std::min(claim, static_cast<std::uint32_t>(least_sum[x]) << 16 | static_cast<std::uint32_t>(disparity));
  }
  const int most_apart = options_.left_right_px < 0 ? size_.width : options_.left_right_px;
  std::uint8_t* agrees = agrees_.data();
  for (int x = extent.begin; x < extent.end; ++x) {
    const int disparity = first[x] + best[x];
    const int at = std::max(x - disparity, 0);
    const int other = static_cast<int>(right[at] & kDisparity);
    const bool covered = right_covered == nullptr || right_covered[at] != 0;
    agrees[x] = static_cast<std::uint8_t>((disparity <= x) & covered & (std::abs(other - disparity) <= most_apart));
  }
}

void Search::judge_row(int v, const SearchedPair& pair, const std::uint8_t* left_covered, float* disparity_px,
                       float* sigma_px, std::uint8_t* match) {
  const std::ptrdiff_t first_pixel = static_cast<std::ptrdiff_t>(v) * size_.width;
  find_agreeing(extent(v), pair.first.row(v), pair.right_covered ? pair.right_covered + first_pixel : nullptr);
  JudgeRow row;
  row.extent = extent(v);
  row.last = options_.disparities - 1;
  row.most = costs_->most();
  row.uniqueness = uniqueness_limit_;
  row.strength = strength_limit_;
  row.peak = peak_limit_;
  row.covered = left_covered ? left_covered + first_pixel : all_covered_.data();
  row.agrees = agrees_.data();
  row.first = pair.first.row(v);
  row.best = best_row();
  row.disparity_px = disparity_px + first_pixel;
  row.sigma_px = sigma_px + first_pixel;
  row.match = match + first_pixel;
  kernels_.judge(row);
}

void Search::run(const SearchedPair& pair, const std::uint8_t* left_covered, float* disparity_px, float* sigma_px,
                 std::uint8_t* match) {
  for (int v = 0; v < size_.height; ++v) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(v) * size_.width;
    Extent& row = extents_[static_cast<std::size_t>(v)];
    row = Extent::of(left_covered ? left_covered + first : nullptr, size_.width);
    row.fill_beyond(disparity_px + first, size_.width, 0.0F);
    row.fill_beyond(sigma_px + first, size_.width, 0.0F);
    row.fill_beyond(match + first, size_.width, static_cast<std::uint8_t>(Match::kUncovered));
  }
  costs_->begin(pair, extents_);
  for (int v = 0; v < size_.height; ++v) {
    gather_down(pair, v);
    if (options_.paths < 4) judge_row(v, pair, left_covered, disparity_px, sigma_px, match);
  }
  if (options_.paths < 4) return;
  std::fill(from_right_.begin(), from_right_.end(), std::uint8_t{0});
  for (int v = size_.height - 1; v >= 0; --v) {
    gather_up(pair, v);
    judge_row(v, pair, left_covered, disparity_px, sigma_px, match);
  }
}

}  // namespace raybundle
