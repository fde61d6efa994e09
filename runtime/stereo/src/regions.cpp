// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "regions.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {

namespace {
constexpr float kSmooth = 0.7F;  // [px] between neighbours: fractions of one surface scatter by less
constexpr auto kMatched = static_cast<std::uint8_t>(Match::kMatched);
}  // namespace

SmallRegions::SmallRegions(ImageSize size) : size_(size) {
  runs_.reserve(static_cast<std::size_t>(size.width) * size.height);
}

int SmallRegions::first_of(int run) {
  while (runs_[static_cast<std::size_t>(run)].parent != run) {
    Run& here = runs_[static_cast<std::size_t>(run)];
    here.parent = runs_[static_cast<std::size_t>(here.parent)].parent;  // halves the way for the next one
    run = here.parent;
  }
  return run;
}

void SmallRegions::join(int a, int b) {
  a = first_of(a);
  b = first_of(b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  runs_[static_cast<std::size_t>(b)].parent = a;
  runs_[static_cast<std::size_t>(a)].pixels += runs_[static_cast<std::size_t>(b)].pixels;
}

int SmallRegions::remove(int least_pixels, float* disparity_px, float* sigma_px, std::uint8_t* match) {
  runs_.clear();
  int above = 0;  // first run of the row above
  int row = 0;    // first run of this row
  for (int v = 0; v < size_.height; ++v) {
    const int begin = v * size_.width;
    const int end = begin + size_.width;
    row = static_cast<int>(runs_.size());
    for (int i = begin; i < end; ++i) {
      if (match[i] != kMatched) continue;
      const int from = i;
      while (i + 1 < end && match[i + 1] == kMatched && std::abs(disparity_px[i + 1] - disparity_px[i]) <= kSmooth) ++i;
      const int run = static_cast<int>(runs_.size());
      runs_.push_back({from, i + 1, run, i + 1 - from});
      // the runs above that overlap it
      while (above < row && runs_[static_cast<std::size_t>(above)].end + size_.width <= from) ++above;
      for (int k = above; k < row && runs_[static_cast<std::size_t>(k)].begin + size_.width <= i; ++k) {
        const int overlap_begin = std::max(from, runs_[static_cast<std::size_t>(k)].begin + size_.width);
        const int overlap_end = std::min(i + 1, runs_[static_cast<std::size_t>(k)].end + size_.width);
        for (int p = overlap_begin; p < overlap_end; ++p) {
          if (std::abs(disparity_px[p] - disparity_px[p - size_.width]) > kSmooth) continue;
          join(k, run);
          break;
        }
      }
    }
    above = row;
  }
  int matched = 0;
  for (int run = 0; run < static_cast<int>(runs_.size()); ++run) {
    const Run& here = runs_[static_cast<std::size_t>(run)];
    if (runs_[static_cast<std::size_t>(first_of(run))].pixels >= least_pixels) {
      matched += here.end - here.begin;
      continue;
    }
    std::fill(disparity_px + here.begin, disparity_px + here.end, 0.0F);
    std::fill(sigma_px + here.begin, sigma_px + here.end, 0.0F);
    std::fill(match + here.begin, match + here.end, static_cast<std::uint8_t>(Match::kIsolated));
  }
  return matched;
}

}  // namespace raybundle
