// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "spot_centre.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace raybundle {
namespace {

constexpr int kHalf = 6;  // of the window
constexpr int kSide = 2 * kHalf + 1;
constexpr int kIterations = 4;
constexpr double kFarthest_px = 2.5;      // from the start
constexpr double kLeastRadius_px = 2.5;   // of the weights
constexpr double kRadiusBySigma = 3.0;    // of the weights over the spot
constexpr double kMostElongated = 4.0;    // longer over shorter axis
constexpr double kHotPixelShare = 0.75;   // of a spot's light in its brightest pixel
constexpr double kMostSaturated = 0.5;    // share of the light's pixels at the largest grey value
constexpr double kLeastOverUnrest = 3.0;  // brightest pixel over the unrest of the surroundings

using Window = std::array<float, kSide * kSide>;

struct Surroundings {
  float level = 0, slope_u = 0, slope_v = 0;  // of a plane
  float sigma = 0;                            // about it
};

// A plane through the window's rim, without what stands out of it: the next dot, an edge's other side.
Surroundings surroundings_of(const Window& window) {
  Surroundings plane;
  const auto each = [](auto&& use) {
    for (int i = -kHalf; i <= kHalf; ++i) {
      use(i, -kHalf);
      use(i, kHalf);
      if (std::abs(i) < kHalf) use(-kHalf, i), use(kHalf, i);
    }
  };
  float limit = 1e9F;
  for (int round = 0; round < 2; ++round) {
    float n = 0, sum = 0, su = 0, sv = 0, suu = 0, svv = 0, squares = 0;
    each([&](int u, int v) {
      const float value = window[(v + kHalf) * kSide + u + kHalf];
      const float fit = plane.level + plane.slope_u * static_cast<float>(u) + plane.slope_v * static_cast<float>(v);
      if (std::abs(value - fit) > limit) return;
      n += 1;
      sum += value;
      su += value * static_cast<float>(u), suu += static_cast<float>(u * u);
      sv += value * static_cast<float>(v), svv += static_cast<float>(v * v);
    });
    if (n < 2 * kSide) break;
    plane = {sum / n, su / suu, sv / svv, 0};
    float kept = 0;
    each([&](int u, int v) {
      const float value = window[(v + kHalf) * kSide + u + kHalf];
      const float fit = plane.level + plane.slope_u * static_cast<float>(u) + plane.slope_v * static_cast<float>(v);
      if (limit < 1e9F && std::abs(value - fit) > limit) return;
      squares += (value - fit) * (value - fit);
      kept += 1;
    });
    plane.sigma = std::sqrt(squares / std::max(1.0F, kept));
    limit = 2.5F * plane.sigma + 1.0F;
  }
  return plane;
}

// Weights along one axis: (1 - d²/r²)², and what the mean needs of them.
struct AxisWeights {
  std::array<float, kSide> weight, moment, steep;

  AxisWeights(double centre, double radius) {
    for (int i = 0; i < kSide; ++i) {
      const double d = i - kHalf - centre, inside = std::max(0.0, 1.0 - d * d / (radius * radius));
      weight[i] = static_cast<float>(inside * inside);
      moment[i] = static_cast<float>(inside * inside * d);
      steep[i] = static_cast<float>(inside * inside - 4.0 * d * d / (radius * radius) * inside);  // d moment / d d
    }
  }
};

struct Moments {
  double light = 0, u = 0, v = 0, uu = 0, vv = 0, uv = 0;  // weighted sums over the window
  double steep_u = 0, steep_v = 0;
};

Moments moments_of(const Window& window, const AxisWeights& along_u, const AxisWeights& along_v,
                   const Eigen::Vector2d& centre) {
  Moments sums;
  for (int y = 0; y < kSide; ++y) {
    if (along_v.weight[y] == 0.0F) continue;
    float light = 0, u = 0, uu = 0, steep = 0;
    for (int x = 0; x < kSide; ++x) {
      const float value = window[y * kSide + x];
      light += value * along_u.weight[x];
      u += value * along_u.moment[x];
      uu += value * along_u.moment[x] * (static_cast<float>(x - kHalf) - static_cast<float>(centre.x()));
      steep += value * along_u.steep[x];
    }
    const double d = y - kHalf - centre.y();
    sums.light += along_v.weight[y] * light;
    sums.u += along_v.weight[y] * u;
    sums.v += along_v.moment[y] * light;
    sums.uu += along_v.weight[y] * uu;
    sums.vv += along_v.moment[y] * d * light;
    sums.uv += along_v.moment[y] * u;
    sums.steep_u += along_v.weight[y] * steep;
    sums.steep_v += along_v.steep[y] * light;
  }
  return sums;
}

// Whether most of the light is in one pixel, or the spot is cut off at the largest grey value.
bool is_defect(const Window& window, const GreyView& on, int u0, int v0, double light) {
  float peak = 0;
  int lit = 0, saturated = 0;
  for (const float value : window) peak = std::max(peak, value);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if (window[y * kSide + x] < 0.3F * peak) continue;
      ++lit;
      saturated += on.at(u0 + x - kHalf, v0 + y - kHalf) == 255;
    }
  }
  return peak > kHotPixelShare * light || (saturated > 4 && saturated > kMostSaturated * lit);
}

}  // namespace

std::optional<Spot> spot_centre(const GreyView& on, const GreyView& off, const Eigen::Vector2d& start,
                                const SpotNoise& noise) {
  const int u0 = static_cast<int>(start.x()), v0 = static_cast<int>(start.y());
  if (u0 < kHalf || v0 < kHalf || u0 + kHalf >= on.width || v0 + kHalf >= on.height) return std::nullopt;
  Window window;
  for (int y = 0; y < kSide; ++y) {
    const std::uint8_t* row = on.row(v0 + y - kHalf) + u0 - kHalf;
    for (int x = 0; x < kSide; ++x) window[y * kSide + x] = row[x];
    if (off.pixels == nullptr) continue;
    row = off.row(v0 + y - kHalf) + u0 - kHalf;
    for (int x = 0; x < kSide; ++x) window[y * kSide + x] -= row[x];
  }
  const Surroundings plane = surroundings_of(window);
  for (int y = 0; y < kSide; ++y) {
    const float level = plane.level + plane.slope_v * static_cast<float>(y - kHalf);
    for (int x = 0; x < kSide; ++x) window[y * kSide + x] -= level + plane.slope_u * static_cast<float>(x - kHalf);
  }

  Eigen::Vector2d centre = start - Eigen::Vector2d(u0, v0);
  const Eigen::Vector2d begin = centre;
  double radius = 4.0;
  Eigen::Matrix2d spread;
  Moments sums;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const AxisWeights along_u(centre.x(), radius), along_v(centre.y(), radius);
    sums = moments_of(window, along_u, along_v, centre);
    if (!(sums.light > 0.0 && sums.steep_u > 0.0 && sums.steep_v > 0.0)) return std::nullopt;
    centre +=
        Eigen::Vector2d(std::clamp(sums.u / sums.steep_u, -1.0, 1.0), std::clamp(sums.v / sums.steep_v, -1.0, 1.0));
    if ((centre - begin).cwiseAbs().maxCoeff() > kFarthest_px) return std::nullopt;
    spread << sums.uu, sums.uv, sums.uv, sums.vv;
    spread /= sums.light;
    // The weights narrow the spot as they would a Gaussian one: 1/s² = 1/spread - 4/r², about its centre.
    const double narrowed = 0.5 * spread.trace(), of_weights = radius * radius / 4.0;
    const double size2 =
        narrowed < 0.9 * of_weights ? narrowed * of_weights / (of_weights - narrowed) : 9.0 * of_weights;
    if (iteration < 2) radius = std::clamp(kRadiusBySigma * std::sqrt(size2), kLeastRadius_px, double(kHalf));
  }

  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
  const double of_weights = radius * radius / 4.0, longer = axes.eigenvalues()[1], shorter = axes.eigenvalues()[0];
  if (!(shorter > 0.0) || longer > kMostElongated * kMostElongated * shorter) return std::nullopt;
  const float peak = *std::max_element(window.begin(), window.end());
  if (peak < kLeastOverUnrest * plane.sigma || is_defect(window, on, u0, v0, sums.light)) return std::nullopt;

  Spot spot;
  spot.pixel = centre + Eigen::Vector2d(u0, v0);
  spot.major_sigma_px =
      std::sqrt(longer < 0.9 * of_weights ? longer * of_weights / (of_weights - longer) : 9.0 * of_weights);
  spot.brightness = sums.light;
  const AxisWeights along_u(centre.x(), radius), along_v(centre.y(), radius);
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  const double unrest = plane.sigma * plane.sigma;
  for (int y = 0; y < kSide; ++y) {
    const std::uint8_t* row = on.row(v0 + y - kHalf) + u0 - kHalf;
    for (int x = 0; x < kSide; ++x) {
      const double pixels = off.pixels == nullptr ? 1.0 : 2.0;
      const double shot = pixels * (noise.read * noise.read + noise.grey_per_electron * row[x] + 1.0 / 12.0);
      const Eigen::Vector2d by(along_u.moment[x] * along_v.weight[y] / sums.steep_u,
                               along_u.weight[x] * along_v.moment[y] / sums.steep_v);
      covariance += std::max(shot, unrest) * by * by.transpose();
    }
  }
  spot.covariance_px2 = covariance;
  return spot;
}

}  // namespace raybundle
