// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/lens_blur.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr double kReach = 4.0;  // standard deviations; beyond lie 6e-5 of the light

// Integral of the normal distribution function.
double integral_of_phi(double x) {
  return x * 0.5 * std::erfc(-x * M_SQRT1_2) + std::exp(-0.5 * x * x) * 0.5 * M_2_SQRTPI * M_SQRT1_2;
}

// Integral of the part of a blurred unit square's side that lies below, over a cell's upper or lower end.
double integral_at(double x, double sigma) {
  if (sigma <= 0) return std::clamp(x, -0.5, 0.5);
  return sigma * (integral_of_phi((x + 0.5) / sigma) - integral_of_phi((x - 0.5) / sigma));
}

}  // namespace

LensBlur::LensBlur(double sigma_px) : reach_(static_cast<int>(std::ceil(kReach * sigma_px))) {
  double sum = 0;
  std::vector<double> weights;
  for (int cell = 0; cell < kCellsPerPixel; ++cell) {
    const double low = static_cast<double>(cell) / kCellsPerPixel - 0.5, high = low + 1.0 / kCellsPerPixel;
    for (int away = -reach_; away <= reach_; ++away) {
      weights.push_back(integral_at(high - away, sigma_px) - integral_at(low - away, sigma_px));
      sum += weights.back();
    }
  }
  for (const double weight : weights) weights_.push_back(static_cast<float>(weight / sum));
}

void LensBlur::add(const CellLight& cells, LightImage& image) const {
  const int width = image.size.width, height = image.size.height;
  const int first = std::max(0, cells.left() - reach_), end = std::min(width, cells.left() + cells.width() + reach_);
  if (first >= end) return;
  std::vector<float> across(width);
  for (int cell_row = 0; cell_row < cells.height() * kCellsPerPixel; ++cell_row) {
    std::fill(across.begin() + first, across.begin() + end, 0.0F);
    for (int i = 0; i < kCellsPerPixel; ++i) {
      const float* light = cells.row(cell_row, i);
      for (int away = -reach_; away <= reach_; ++away) {
        const float w = weight(i, away);
        const int shift = cells.left() + away;
        const int from = std::max(0, -shift), to = std::min(cells.width(), width - shift);
        float* sum = across.data() + shift;
        for (int x = from; x < to; ++x) sum[x] += w * light[x];
      }
    }
    const int y = cells.top() + cell_row / kCellsPerPixel;
    for (int away = -reach_; away <= reach_; ++away) {
      if (y + away < 0 || y + away >= height) continue;
      const float w = weight(cell_row % kCellsPerPixel, away);
      float* sum = image.values.data() + static_cast<std::size_t>(y + away) * width;
      for (int x = first; x < end; ++x) sum[x] += w * across[x];
    }
  }
}

}  // namespace raybundle
