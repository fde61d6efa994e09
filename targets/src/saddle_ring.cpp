// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "raybundle/geometry/target_clones.hpp"
#include "saddle.hpp"

namespace raybundle {
namespace {

constexpr int kSamples = 32;

/// Unit vectors of the samples, clockwise from x.
struct Directions {
  std::array<float, kSamples> x, y;
};
const Directions& ring_directions() {
  static const auto directions = [] {
    Directions out;
    for (int i = 0; i < kSamples; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSamples;
      out.x[i] = static_cast<float>(std::cos(angle));
      out.y[i] = static_cast<float>(std::sin(angle));
    }
    return out;
  }();
  return directions;
}

/// Grey values on the ring, bilinear.
RAYBUNDLE_TARGET_CLONES void sample_ring(const cv::Mat& gray, const Eigen::Vector2f& centre, float radius_px,
                                         const Directions& directions, std::array<float, kSamples>& value) {
  const float centre_x = centre[0], centre_y = centre[1];
  std::array<int, kSamples> column, row;
  std::array<float, kSamples> fx, fy, top_left, top_right, bottom_left, bottom_right;
  for (int i = 0; i < kSamples; ++i) {
    const float x = centre_x + radius_px * directions.x[i], y = centre_y + radius_px * directions.y[i];
    column[i] = static_cast<int>(x);
    row[i] = static_cast<int>(y);
    fx[i] = x - static_cast<float>(column[i]);
    fy[i] = y - static_cast<float>(row[i]);
  }
  for (int i = 0; i < kSamples; ++i) {
    const uchar *top = gray.data + row[i] * gray.step[0] + column[i], *bottom = top + gray.step[0];
    top_left[i] = top[0], top_right[i] = top[1], bottom_left[i] = bottom[0], bottom_right[i] = bottom[1];
  }
  for (int i = 0; i < kSamples; ++i) {
    const float top = (1 - fx[i]) * top_left[i] + fx[i] * top_right[i];
    const float bottom = (1 - fx[i]) * bottom_left[i] + fx[i] * bottom_right[i];
    value[i] = (1 - fy[i]) * top + fy[i] * bottom;
  }
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
  sample_ring(gray, centre.cast<float>(), static_cast<float>(radius_px), ring_directions(), value);
  float low = 255, high = 0;
  for (const float grey : value) {
    low = std::min(low, grey);
    high = std::max(high, grey);
  }
  if (high - low < 8) return std::nullopt;
  const float middle = 0.5F * (low + high);

  // Exactly four changes, opposite ones about half a turn apart. `rising`: dark to bright, clockwise.
  std::uint32_t dark = 0;
  for (int i = 0; i < kSamples; ++i) dark |= static_cast<std::uint32_t>(value[i] - middle < 0) << i;
  std::uint32_t changes = dark ^ std::rotr(dark, 1);
  if (std::popcount(changes) != 4) return std::nullopt;
  const bool first_rises = (dark >> std::countr_zero(changes) & 1) != 0;
  double crossing[4];
  for (double& at : crossing) {
    const int i = std::countr_zero(changes);
    changes &= changes - 1;
    const float here = value[i] - middle, next = value[(i + 1) % kSamples] - middle;
    at = 2 * kPi / kSamples * (i + static_cast<double>(here / (here - next)));
  }
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
