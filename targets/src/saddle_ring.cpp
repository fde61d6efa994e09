// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <numbers>

#include "saddle.hpp"

namespace raybundle {
namespace {

constexpr int kSamples = 32;

/// Unit vectors of the samples, clockwise from x.
const std::array<Eigen::Vector2f, kSamples>& ring_directions() {
  static const auto directions = [] {
    std::array<Eigen::Vector2f, kSamples> out;
    for (int i = 0; i < kSamples; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSamples;
      out[i] = Eigen::Vector2d(std::cos(angle), std::sin(angle)).cast<float>();
    }
    return out;
  }();
  return directions;
}

float bilinear(const cv::Mat& gray, float x, float y) {
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const uchar* top = gray.ptr<uchar>(y0) + x0;
  const uchar* bottom = top + gray.step[0];
  return (1 - fy) * ((1 - fx) * top[0] + fx * top[1]) + fy * ((1 - fx) * bottom[0] + fx * bottom[1]);
}

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace

std::optional<SaddleRing> saddle_ring(const cv::Mat& gray, const Eigen::Vector2d& centre, double radius_px) {
  constexpr double kPi = std::numbers::pi;
  if (!(centre.x() >= radius_px && centre.y() >= radius_px && centre.x() < gray.cols - 1 - radius_px &&
        centre.y() < gray.rows - 1 - radius_px)) {
    return std::nullopt;
  }
  std::array<float, kSamples> value;
  float low = 255, high = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector2f at = centre.cast<float>() + static_cast<float>(radius_px) * ring_directions()[i];
    value[i] = bilinear(gray, at.x(), at.y());
    low = std::min(low, value[i]);
    high = std::max(high, value[i]);
  }
  if (high - low < 8) return std::nullopt;
  const float middle = 0.5F * (low + high);

  // Exactly four changes, opposite ones about half a turn apart. `rising`: dark to bright, clockwise.
  double crossing[4];
  int crossings = 0;
  bool first_rises = false;
  for (int i = 0; i < kSamples; ++i) {
    const float here = value[i] - middle;
    const float next = value[(i + 1) % kSamples] - middle;
    if ((here < 0) == (next < 0)) continue;
    if (crossings == 4) return std::nullopt;
    if (crossings == 0) first_rises = here < 0;
    crossing[crossings++] = 2 * kPi / kSamples * (i + static_cast<double>(here / (here - next)));
  }
  if (crossings != 4) return std::nullopt;
  constexpr double kBent = 0.7;  // [rad] opposite edges may differ this much: blur, a centre that is a pixel off
  const double straight_0 = wrapped(crossing[2] - crossing[0] - kPi);
  const double straight_1 = wrapped(crossing[3] - crossing[1] - kPi);
  if (std::abs(straight_0) > kBent || std::abs(straight_1) > kBent) return std::nullopt;

  SaddleRing ring;
  ring.contrast = high - low;
  const double axis_0 = crossing[0] + 0.5 * straight_0;
  const double axis_1 = crossing[1] + 0.5 * straight_1;
  ring.angle_a = first_rises ? axis_0 : axis_1 - kPi;
  ring.angle_b = first_rises ? axis_1 : axis_0;
  const double opening = ring.angle_b - ring.angle_a;
  constexpr double kNarrow = 0.25;  // [rad]
  if (opening < kNarrow || opening > kPi - kNarrow) return std::nullopt;
  return ring;
}

}  // namespace raybundle
