// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "pyramid.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr int kAround = 64;  // disparities searched around those of a coarser level
constexpr int kStep = 32;    // where they begin is rounded: only pixels that begin at the same one help each other

MatchOptions level_options(MatchOptions options, bool coarser) {
  if (coarser) options.disparities = std::min(options.disparities, kAround);
  return options;
}

std::size_t pixels_of(ImageSize size) { return static_cast<std::size_t>(size.width) * size.height; }

void halve_image(GreyView from, const std::uint8_t* covered, PyramidLevel::Image& to) {
  std::fill(to.covered.begin(), to.covered.end(), std::uint8_t{1});
  std::size_t i = 0;
  for (int v = 0; v < to.size.height; ++v) {
    const std::uint8_t* above = from.row(2 * v);
    const std::uint8_t* below = from.row(2 * v + 1);
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(2 * v) * from.width;
    for (int u = 0; u < to.size.width; ++u, ++i) {
      to.pixels[i] =
          static_cast<std::uint8_t>((above[2 * u] + above[2 * u + 1] + below[2 * u] + below[2 * u + 1] + 2) / 4);
      if (covered == nullptr) continue;
      const std::uint8_t* here = covered + first + 2 * u;
      to.covered[i] = here[0] & here[1] & here[from.width] & here[from.width + 1];
    }
  }
}

// What is not known becomes the lesser of its neighbours to the left and right: what is hidden lies behind.
void fill_row(const float* disparity_px, int width, std::vector<float>& filled) {
  if (std::none_of(disparity_px, disparity_px + width, [](float d) { return d > 0; })) return;
  int known = -1;
  for (int x = 0; x <= width; ++x) {
    if (x < width && !(disparity_px[x] > 0)) continue;
    const float behind = x < width ? disparity_px[x] : disparity_px[known];
    const float before = known < 0 ? behind : disparity_px[known];
    std::fill(filled.begin() + known + 1, filled.begin() + x, std::min(before, behind));
    if (x < width) filled[static_cast<std::size_t>(x)] = disparity_px[x];
    known = x;
  }
}

}  // namespace

PyramidLevel::PyramidLevel(ImageSize size, const MatchOptions& options, bool coarser, bool halved)
    : size_(size),
      options_(level_options(options, coarser)),
      last_first_(std::min(options.least_disparity + options.disparities - options_.disparities, size.width - 1)),
      search_(size, options_),
      regions_(size),
      first_(pixels_of(size), static_cast<std::int16_t>(options.least_disparity)),
      disparity_px_(pixels_of(size)),
      sigma_px_(pixels_of(size)),
      match_(pixels_of(size)),
      guide_px_(static_cast<std::size_t>(size.width / 2)) {
  if (!halved) {
    if (options.refine) refinement_.emplace(size, options.noise_grey, row_kernels(options.simd));
    return;
  }
  for (Image* image : {&left_, &right_}) {
    *image = {size, std::vector<std::uint8_t>(pixels_of(size)), std::vector<std::uint8_t>(pixels_of(size), 1)};
  }
}

void PyramidLevel::halve(GreyView left, GreyView right, const std::uint8_t* left_covered,
                         const std::uint8_t* right_covered) {
  halve_image(left, left_covered, left_);
  halve_image(right, right_covered, right_);
}

void PyramidLevel::search(GreyView left, GreyView right, const std::uint8_t* left_covered,
                          const std::uint8_t* right_covered) {
  const ImageView<const std::int16_t> first{first_.data(), size_.width, size_.height, size_.width};
  search_.run({left, right, right_covered, first}, left_covered, disparity_px_.data(), sigma_px_.data(), match_.data());
  matched_ = regions_.remove(options_.least_region_px, disparity_px_.data(), sigma_px_.data(), match_.data());
  if (refinement_)
    refinement_->run(left, right, search_.extents(), right_covered, disparity_px_.data(), sigma_px_.data());
}

void PyramidLevel::search_around(const PyramidLevel& coarser) {
  const DisparityView guide = coarser.found();
  std::fill(guide_px_.begin(), guide_px_.end(), 0.5F * static_cast<float>(options_.least_disparity));
  for (int v = 0; v < size_.height; ++v) {
    if (v % 2 == 0 && v / 2 < guide.disparity_px.height) {
      fill_row(guide.disparity_px.row(v / 2), guide.disparity_px.width, guide_px_);
    }
    std::int16_t* first = first_.data() + static_cast<std::ptrdiff_t>(v) * size_.width;
    for (int u = 0; u < size_.width; ++u) {
      const auto at = static_cast<std::size_t>(std::min(u / 2, guide.disparity_px.width - 1));
      const int middle = static_cast<int>(std::lround(2.0F * guide_px_[at]));
      first[u] = static_cast<std::int16_t>(std::clamp((middle - (kAround - kStep) / 2) / kStep * kStep,
                                                      std::min(options_.least_disparity, last_first_), last_first_));
    }
  }
}

DisparityView PyramidLevel::found() const {
  return {{disparity_px_.data(), size_.width, size_.height, size_.width},
          {sigma_px_.data(), size_.width, size_.height, size_.width},
          {match_.data(), size_.width, size_.height, size_.width},
          matched_};
}

MatchOptions halved(MatchOptions options) {
  const int last = options.least_disparity + options.disparities - 1;
  options.least_disparity /= 2;
  options.disparities = (last + 1) / 2 - options.least_disparity + 2;
  options.least_region_px = (options.least_region_px + 3) / 4;
  return options;
}

std::vector<PyramidLevel> pyramid(ImageSize size, const MatchOptions& options) {
  std::vector<PyramidLevel> levels;
  MatchOptions here = options;
  for (int k = 0; k <= options.coarse_levels; ++k) {
    levels.emplace_back(size, here, k<options.coarse_levels, k> 0);
    here = halved(here);
    size = {size.width / 2, size.height / 2};
  }
  return levels;
}

}  // namespace raybundle
