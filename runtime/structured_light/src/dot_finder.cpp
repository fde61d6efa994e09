// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/dot_finder.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "spot_centre.hpp"

namespace raybundle {
namespace {

constexpr int kRing = 2;           // at half the resolution: beyond most of a spot, but near, for light is uneven
constexpr int kWeights = 16;       // of the smoothing, 1 2 1 both ways
constexpr double kNoiseGain = 12;  // sigma of a smoothed value over that of a pixel: sqrt(4 * 36)
constexpr int kPeaksPerDot = 2;    // that are looked at, of the most dots

}  // namespace

DotFinder::DotFinder(ImageSize size, int most_dots, const DotFinderOptions& options)
    : size_(size),
      options_(options),
      width_(size.width / 2),
      height_(size.height / 2),
      half_(static_cast<std::size_t>(width_) * height_),
      rows_(half_.size()),
      smooth_(half_.size()),
      signal_(half_.size()),
      most_peaks_(static_cast<std::size_t>(kPeaksPerDot) * most_dots),
      most_dots_(most_dots) {
  peaks_.reserve(static_cast<std::size_t>(width_ / 2 + 1) * (height_ / 2 + 1));  // no two are neighbours
  dots_.reserve(most_peaks_);
}

// Sums of two by two pixels, of the difference where there is an image without the laser.
void DotFinder::halve(const GreyView& on, const GreyView& off) {
  for (int v = 0; v < height_; ++v) {
    const std::uint8_t *upper = on.row(2 * v), *lower = on.row(2 * v + 1);
    std::int16_t* half = half_.data() + static_cast<std::ptrdiff_t>(v) * width_;
    for (int u = 0; u < width_; ++u) {
      half[u] = static_cast<std::int16_t>(upper[2 * u] + upper[2 * u + 1] + lower[2 * u] + lower[2 * u + 1]);
    }
    if (off.pixels == nullptr) continue;
    upper = off.row(2 * v);
    lower = off.row(2 * v + 1);
    for (int u = 0; u < width_; ++u) {
      half[u] = static_cast<std::int16_t>(half[u] - upper[2 * u] - upper[2 * u + 1] - lower[2 * u] - lower[2 * u + 1]);
    }
  }
}

// 1 2 1 along rows, then along columns; the rim stays zero and is not searched.
void DotFinder::smooth() {
  for (int v = 0; v < height_; ++v) {
    const std::int16_t* half = half_.data() + static_cast<std::ptrdiff_t>(v) * width_;
    std::int16_t* row = rows_.data() + static_cast<std::ptrdiff_t>(v) * width_;
    for (int u = 1; u < width_ - 1; ++u) row[u] = static_cast<std::int16_t>(half[u - 1] + 2 * half[u] + half[u + 1]);
  }
  for (int v = 1; v < height_ - 1; ++v) {
    const std::int16_t* row = rows_.data() + static_cast<std::ptrdiff_t>(v) * width_;
    std::int16_t* out = smooth_.data() + static_cast<std::ptrdiff_t>(v) * width_;
    for (int u = 0; u < width_; ++u) {
      out[u] = static_cast<std::int16_t>(row[u - width_] + 2 * row[u] + row[u + width_]);
    }
  }
}

// How much each place outshines the brightest of the pairs of opposite places around it. A slope of light leaves the
// means of pairs alone; an edge or a ridge lifts that of the pair along it.
void DotFinder::outshine() {
  const std::ptrdiff_t w = width_;
  for (int v = kRing + 1; v < height_ - kRing - 1; ++v) {
    const std::int16_t* s = smooth_.data() + v * w;
    std::int16_t* signal = signal_.data() + v * w;
    for (int u = kRing + 1; u < width_ - kRing - 1; ++u) {
      const auto pair = [s, u](std::ptrdiff_t step) {
        return static_cast<std::int16_t>((s[u - step] >> 1) + (s[u + step] >> 1));
      };
      const std::int16_t straight = std::max(pair(kRing), pair(kRing * w));
      const std::int16_t rising = std::max(pair(w + kRing), pair(kRing * w + 1));
      const std::int16_t falling = std::max(pair(w - kRing), pair(kRing * w - 1));
      signal[u] = static_cast<std::int16_t>(s[u] - std::max(straight, std::max(rising, falling)));
    }
  }
}

// Where that is more than noise, and more than next to it.
void DotFinder::find_peaks(const GreyView& on, bool difference) {
  peaks_.clear();
  const double images = difference ? 2.0 : 1.0;  // whose noise is in a value
  const double dark = images * options_.read_noise * options_.read_noise;
  const auto least = static_cast<std::int16_t>(
      std::min(30000.0, std::max(double(kWeights), options_.least_signal * kNoiseGain * std::sqrt(dark))));
  const std::ptrdiff_t w = width_;
  for (int v = kRing + 1; v < height_ - kRing - 1; ++v) {
    const std::int16_t* s = signal_.data() + v * w;
    for (int u = kRing + 1; u < width_ - kRing - 1; ++u) {
      const std::int16_t here = s[u];
      if (here < least) continue;
      const bool highest = here > s[u - 1] && here >= s[u + 1] && here > s[u - w - 1] && here > s[u - w] &&
                           here > s[u - w + 1] && here >= s[u + w - 1] && here >= s[u + w] && here >= s[u + w + 1];
      if (!highest) continue;
      const double grey = on.at(2 * u, 2 * v);
      const double sigma = kNoiseGain * std::sqrt(dark + images * options_.grey_per_electron * grey);
      if (here >= options_.least_signal * sigma && peaks_.size() < peaks_.capacity()) peaks_.push_back({u, v, here});
    }
  }
}

void DotFinder::keep_strongest_peaks() {
  if (peaks_.size() <= most_peaks_) return;
  const auto place = [](const Peak& peak) { return std::pair(peak.v, peak.u); };
  const auto end = peaks_.begin() + static_cast<std::ptrdiff_t>(most_peaks_);
  std::nth_element(peaks_.begin(), end, peaks_.end(), [&](const Peak& a, const Peak& b) {
    return a.signal != b.signal ? a.signal > b.signal : place(a) < place(b);
  });
  peaks_.resize(most_peaks_);
  std::sort(peaks_.begin(), peaks_.end(), [&](const Peak& a, const Peak& b) { return place(a) < place(b); });
}

std::span<const Dot> DotFinder::find(const GreyView& on, const GreyView& off) {
  assert(on.width == size_.width && on.height == size_.height);
  halve(on, off);
  smooth();
  outshine();
  find_peaks(on, off.pixels != nullptr);
  keep_strongest_peaks();
  dots_.clear();
  const SpotNoise noise{options_.read_noise, options_.grey_per_electron};
  for (const Peak& peak : peaks_) {
    const auto spot = spot_centre(on, off, {2.0 * peak.u + 0.5, 2.0 * peak.v + 0.5}, noise);
    if (!spot || spot->major_sigma_px > options_.largest_sigma_px) continue;
    // Corners and steps of a rim of sunlight look like wide spots in great unrest.
    if (0.5 * spot->covariance_px2.trace() > options_.most_uncertain_px * options_.most_uncertain_px) continue;
    dots_.push_back({spot->pixel, spot->covariance_px2, kUnlabelled, spot->brightness});
  }
  if (dots_.size() > most_dots_) {
    const auto end = dots_.begin() + static_cast<std::ptrdiff_t>(most_dots_);
    std::nth_element(dots_.begin(), end, dots_.end(),
                     [](const Dot& a, const Dot& b) { return a.brightness > b.brightness; });
    dots_.resize(most_dots_);
    std::sort(dots_.begin(), dots_.end(), [](const Dot& a, const Dot& b) {
      return std::pair(a.pixel.y(), a.pixel.x()) < std::pair(b.pixel.y(), b.pixel.x());
    });
  }
  return dots_;
}

}  // namespace raybundle
