// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/matcher.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "census_costs.hpp"
#include "raybundle/geometry/error.hpp"
#include "regions.hpp"
#include "row_kernels.hpp"
#include "sub_pixel.hpp"

namespace raybundle {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr std::uint8_t kNone = 255;
constexpr int kPaths = 5;

int lanes_for(int disparities) {
  for (const int lanes : {32, 64, 96, 128, 192}) {
    if (disparities <= lanes) return lanes;
  }
  return 256;
}

void require(bool holds, const std::string& message) {
  if (!holds) throw Error(ErrorKind::kBadInput, message);
}

const MatchOptions& checked(ImageSize size, const MatchOptions& options) {
  require(size.width >= 16 && size.height >= 16, "images to be matched have at least 16x16 pixels");
  require(options.disparities >= 1 && options.disparities <= 256, "the number of disparities is from 1 to 256");
  require(options.least_disparity >= 0 && options.least_disparity < size.width,
          "the least disparity is from 0 to the width of the image");
  require(!options.mask.empty() && options.mask.size() <= 120, "a census mask has from 1 to 120 neighbours");
  for (const auto& [x, y] : options.mask) {
    require(std::abs(x) <= 15 && std::abs(y) <= 15, "the neighbours of a census mask are within 15 px");
  }
  require(options.window_px == 1 || options.window_px == 3, "the window's side is 1 or 3 px");
  require(options.small_step >= 0 && options.small_step <= options.large_step && options.large_step <= 1.5,
          "the costs of steps are from 0 to 1.5, the small one at most the large one");
  return options;
}

}  // namespace

std::string_view match_name(Match match) {
  constexpr std::string_view kNames[kMatchKinds] = {"uncovered", "matched",   "weak",    "ambiguous",
                                                    "flat",      "one_sided", "isolated"};
  return kNames[static_cast<int>(match)];
}

struct Matcher::Data {
  MatchOptions options;
  ImageSize size;
  int lanes;
  const RowKernels& kernels;
  CensusCosts costs;
  Bytes sums, above[3];
  Bytes best, least_sum, second, before, cost, after;  // of a row, as BestRow
  Bytes right_sum, right_best;                         // the same row seen from the right image
  std::vector<float> disparity_px;
  Bytes match;
  SmallRegions regions;

  Data(ImageSize image_size, const MatchOptions& match_options)
      : options(match_options),
        size(image_size),
        lanes(lanes_for(options.disparities)),
        kernels(row_kernels(options.simd)),
        costs(size, lanes, options, kernels),
        regions(size) {
    const auto width = static_cast<std::size_t>(size.width);
    sums.resize(width * lanes);
    for (Bytes& path : above) path.assign(width * (lanes + 32) + 32, kNone);
    for (Bytes* bytes : {&best, &least_sum, &second, &before, &cost, &after, &right_sum, &right_best}) {
      bytes->resize(width);
    }
    disparity_px.resize(width * size.height);
    match.resize(width * size.height);
  }

  void gather(int v, const std::uint8_t* row_costs) {
    PathRow row;
    row.width = size.width;
    row.lanes = lanes;
    row.disparities = options.disparities;
    row.row = v;
    row.small_step = static_cast<std::uint8_t>(std::lround(options.small_step * costs.most()));
    row.large_step = static_cast<std::uint8_t>(std::lround(options.large_step * costs.most()));
    row.costs = row_costs;
    row.sums = sums.data();
    for (int k = 0; k < 3; ++k) row.above[k] = above[k].data() + 32;
    row.best = {best.data(), least_sum.data(), second.data(), before.data(), cost.data(), after.data()};
    (options.paths ? kernels.paths : kernels.best)(row);
  }

  // Of the left image's pixels that claim a pixel of the right image, the one with the least sum gets it.
  void fill_right() {
    std::fill(right_sum.begin(), right_sum.end(), kNone);
    std::fill(right_best.begin(), right_best.end(), kNone);
    for (int x = options.least_disparity; x < size.width; ++x) {
      const int at = x - options.least_disparity - best[static_cast<std::size_t>(x)];
      if (at < 0 || least_sum[static_cast<std::size_t>(x)] >= right_sum[static_cast<std::size_t>(at)]) continue;
      right_sum[static_cast<std::size_t>(at)] = least_sum[static_cast<std::size_t>(x)];
      right_best[static_cast<std::size_t>(at)] = best[static_cast<std::size_t>(x)];
    }
  }

  Match judged(std::size_t x, const std::uint8_t* right_covered, int uniqueness_limit, int strength_limit,
               int peak_limit) const {
    const int d = best[x];
    const int at = static_cast<int>(x) - options.least_disparity - d;
    if (at < 0 || d + 1 == options.disparities) return Match::kOneSided;
    if (right_covered != nullptr && right_covered[at] == 0) return Match::kOneSided;
    if (options.left_right_px >= 0 && std::abs(right_best[static_cast<std::size_t>(at)] - d) > options.left_right_px) {
      return Match::kOneSided;
    }
    if (cost[x] > strength_limit) return Match::kWeak;
    if (second[x] - least_sum[x] < uniqueness_limit) return Match::kAmbiguous;
    if (options.peak > 0 && std::min(before[x], after[x]) - cost[x] < peak_limit) return Match::kFlat;
    return Match::kMatched;
  }

  void judge(int v, const std::uint8_t* left_covered, const std::uint8_t* right_covered) {
    const int uniqueness_limit =
        static_cast<int>(std::ceil(options.uniqueness * costs.most() * (options.paths ? kPaths : 1)));
    const int strength_limit = static_cast<int>(options.strength * costs.most());
    const int peak_limit = static_cast<int>(std::ceil(options.peak * costs.most()));
    const std::size_t first = static_cast<std::size_t>(v) * size.width;
    for (std::size_t x = 0; x < best.size(); ++x) {
      const bool covered = left_covered == nullptr || left_covered[first + x] != 0;
      const Match state = covered ? judged(x, right_covered ? right_covered + first : nullptr, uniqueness_limit,
                                           strength_limit, peak_limit)
                                  : Match::kUncovered;
      match[first + x] = static_cast<std::uint8_t>(state);
      disparity_px[first + x] = state == Match::kMatched ? static_cast<float>(best[x] + options.least_disparity) +
                                                               sub_pixel(before[x], cost[x], after[x])
                                                         : 0.0F;
    }
  }
};

Matcher::Matcher(ImageSize size, const MatchOptions& options)
    : data_(std::make_unique<Data>(size, checked(size, options))) {}
Matcher::~Matcher() = default;
Matcher::Matcher(Matcher&&) noexcept = default;
Matcher& Matcher::operator=(Matcher&&) noexcept = default;

DisparityView Matcher::match(GreyView left, GreyView right, const std::uint8_t* left_covered,
                             const std::uint8_t* right_covered) {
  Data& own = *data_;
  own.costs.begin(left, right);
  for (int v = 0; v < own.size.height; ++v) {
    own.gather(v, own.costs.row(v, right_covered));
    own.fill_right();
    own.judge(v, left_covered, right_covered);
  }
  const int matched = own.regions.remove(own.options.least_region_px, own.disparity_px.data(), own.match.data());
  const auto [width, height] = own.size;
  return {{own.disparity_px.data(), width, height, width}, {own.match.data(), width, height, width}, matched};
}

}  // namespace raybundle
