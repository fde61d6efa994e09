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
constexpr int kNearRim = 4;                // of small spots' surroundings
constexpr double kLargestOfNear_px = 1.3;  // sigma of a spot that leaves the near rim dark
constexpr int kIterations = 4;
constexpr double kSettled_px = 0.003;     // what an iteration moves the centre by
constexpr double kFarthest_px = 2.5;      // from the start
constexpr double kLeastRadius_px = 2.5;   // of the weights
constexpr double kRadiusBySigma = 3.0;    // of the weights over the spot
constexpr double kMostElongated = 4.0;    // longer over shorter axis
constexpr double kHotPixelShare = 0.75;   // of a spot's light in its brightest pixel
constexpr double kMostSaturated = 0.5;    // share of the light's pixels at the largest grey value
constexpr double kLeastOverUnrest = 3.0;  // brightest pixel over the unrest of the surroundings

constexpr int kLanes = 16;  // of a row of the window, whose last ones stay zero: rows are worked on as vectors

// Values around a place, its rows kLanes apart.
using Row = std::array<float, kLanes>;
using Window = std::array<Row, kSide>;

struct Surroundings {
  float level = 0, slope_u = 0, slope_v = 0;  // of a plane
  float sigma = 0;                            // about it
};

// A plane through a square ring around the window's middle, without what stands out of it: the next dot, an edge's
// other side.
Surroundings surroundings_of(const Window& window, int rim) {
  Surroundings plane;
  const auto each = [rim](auto&& use) {
    for (int i = -rim; i <= rim; ++i) {
      use(i, -rim);
      use(i, rim);
      if (std::abs(i) < rim) use(-rim, i), use(rim, i);
    }
  };
  const auto off = [&](int u, int v) {
    return window[v + kHalf][u + kHalf] - plane.level - plane.slope_u * static_cast<float>(u) -
           plane.slope_v * static_cast<float>(v);
  };
  float limit = 1e9F;
  for (int round = 0; round < 2; ++round) {
    // What is left over is fitted: where some of the ring is left out, the sums of u and v are not zero.
    float n = 0, sum = 0, su = 0, sv = 0, suu = 0, svv = 0, squares = 0;
    each([&](int u, int v) {
      const float value = off(u, v);
      if (std::abs(value) > limit) return;
      n += 1;
      sum += value;
      su += value * static_cast<float>(u), suu += static_cast<float>(u * u);
      sv += value * static_cast<float>(v), svv += static_cast<float>(v * v);
    });
    if (n < static_cast<float>(4 * rim)) break;
    plane.level += sum / n;
    plane.slope_u += su / suu;
    plane.slope_v += sv / svv;
    float kept = 0;
    each([&](int u, int v) {
      const float value = off(u, v);
      if (std::abs(value) > limit) return;
      squares += value * value;
      kept += 1;
    });
    plane.sigma = std::sqrt(squares / std::max(1.0F, kept));
    limit = 2.5F * plane.sigma + 1.0F;
  }
  return plane;
}

// Weights along one axis: (1 - d²/r²)², zero beyond r, and what the mean needs of them.
struct AxisWeights {
  Row weight{}, moment{}, square{}, steep{};  // of the window's indices; times d, times d², and d moment / d d
  int first, last;                            // that are not zero

  AxisWeights(double centre, double radius)
      : first(std::max(0, static_cast<int>(std::ceil(kHalf + centre - radius)))),
        last(std::min(kSide - 1, static_cast<int>(std::floor(kHalf + centre + radius)))) {
    const auto per_r2 = static_cast<float>(1.0 / (radius * radius));
    for (int i = first; i <= last; ++i) {
      const auto d = static_cast<float>(i - kHalf - centre);
      const float inside = 1.0F - d * d * per_r2;
      weight[i] = inside * inside;
      moment[i] = weight[i] * d;
      square[i] = moment[i] * d;
      steep[i] = weight[i] - 4.0F * d * d * per_r2 * inside;
    }
  }
};

struct Moments {
  double light = 0, u = 0, v = 0, uu = 0, vv = 0, uv = 0;  // weighted sums over the window
  double steep_u = 0, steep_v = 0;
};

double dot(const Row& a, const Row& b) {
  return Eigen::Map<const Eigen::Array<float, kLanes, 1>>(a.data())
      .cwiseProduct(Eigen::Map<const Eigen::Array<float, kLanes, 1>>(b.data()))
      .sum();
}

Moments moments_of(const Window& window, const AxisWeights& along_u, const AxisWeights& along_v) {
  Row light{}, v{}, vv{}, steep{};  // sums over columns
  for (int y = along_v.first; y <= along_v.last; ++y) {
    for (int x = 0; x < kLanes; ++x) {
      const float value = window[y][x];
      light[x] += along_v.weight[y] * value;
      v[x] += along_v.moment[y] * value;
      vv[x] += along_v.square[y] * value;
      steep[x] += along_v.steep[y] * value;
    }
  }
  return {.light = dot(along_u.weight, light),
          .u = dot(along_u.moment, light),
          .v = dot(along_u.weight, v),
          .uu = dot(along_u.square, light),
          .vv = dot(along_u.weight, vv),
          .uv = dot(along_u.moment, v),
          .steep_u = dot(along_u.steep, light),
          .steep_v = dot(along_u.weight, steep)};
}

// Whether most of the light is in one pixel, or the spot is cut off at the largest grey value.
bool is_defect(const Window& window, const GreyView& on, int u0, int v0, float peak, double light) {
  if (peak > kHotPixelShare * light) return true;
  int lit = 0, saturated = 0;
  for (int y = 0; y < kSide; ++y) {
    const std::uint8_t* row = on.row(v0 + y - kHalf) + u0 - kHalf;
    for (int x = 0; x < kSide; ++x) {
      const bool bright = window[y][x] >= 0.3F * peak;
      lit += bright;
      saturated += bright & (row[x] == 255);
    }
  }
  return saturated > 4 && saturated > kMostSaturated * lit;
}

// A spot's light above its surroundings, and its centre.
struct Fit {
  Window light{};
  Surroundings plane;
  Eigen::Vector2d centre;  // from the window's middle
  Eigen::Matrix2d spread;  // of the light within the weights
  Moments sums;
  double radius = 0.0;  // of the weights

  // Variance of the light without the weights, which narrow it as they would a Gaussian: 1/s² = 1/spread - 4/r².
  double widened(double variance) const {
    const double of_weights = radius * radius / 4.0;
    return variance < 0.9 * of_weights ? variance * of_weights / (of_weights - variance) : 9.0 * of_weights;
  }
};

std::optional<Fit> fit_spot(const Window& window, const Eigen::Vector2d& begin, int rim) {
  Fit fit;
  fit.plane = surroundings_of(window, rim);
  for (int y = 0; y < kSide; ++y) {
    const float level = fit.plane.level + fit.plane.slope_v * static_cast<float>(y - kHalf);
    for (int x = 0; x < kSide; ++x) {
      fit.light[y][x] = window[y][x] - level - fit.plane.slope_u * static_cast<float>(x - kHalf);
    }
  }
  fit.centre = begin;
  fit.radius = std::min(4.0, double(rim));
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const AxisWeights along_u(fit.centre.x(), fit.radius), along_v(fit.centre.y(), fit.radius);
    fit.sums = moments_of(fit.light, along_u, along_v);
    const Moments& sums = fit.sums;
    if (!(sums.light > 0.0 && sums.steep_u > 0.0 && sums.steep_v > 0.0)) return std::nullopt;
    fit.centre +=
        Eigen::Vector2d(std::clamp(sums.u / sums.steep_u, -1.0, 1.0), std::clamp(sums.v / sums.steep_v, -1.0, 1.0));
    if ((fit.centre - begin).cwiseAbs().maxCoeff() > kFarthest_px) return std::nullopt;
    fit.spread << sums.uu, sums.uv, sums.uv, sums.vv;
    fit.spread /= sums.light;
    const double moved = std::max(std::abs(sums.u / sums.steep_u), std::abs(sums.v / sums.steep_v));
    if (iteration >= 2 && moved < kSettled_px) break;
    const double size2 = fit.widened(std::max(0.0, 0.5 * fit.spread.trace()));
    if (iteration < 2) fit.radius = std::clamp(kRadiusBySigma * std::sqrt(size2), kLeastRadius_px, double(rim));
  }
  return fit;
}

// Of shot noise, read noise and rounding, or of the unrest around the spot where that is more.
Eigen::Matrix2d covariance_of(const Fit& fit, const GreyView& on, int u0, int v0, double images,
                              const SpotNoise& noise) {
  const AxisWeights along_u(fit.centre.x(), fit.radius), along_v(fit.centre.y(), fit.radius);
  const float unrest = fit.plane.sigma * fit.plane.sigma;
  const auto dark = static_cast<float>(images * (noise.read * noise.read + 1.0 / 12.0));
  const auto per_grey = static_cast<float>(images * noise.grey_per_electron);
  Row uu{}, uv{}, vv{};  // sums over columns of the noise times the squared weights along v
  for (int y = along_v.first; y <= along_v.last; ++y) {
    const std::uint8_t* row = on.row(v0 + y - kHalf) + u0 - kHalf;
    const float weight = along_v.weight[y], moment = along_v.moment[y];
    for (int x = 0; x < kSide; ++x) {
      const float variance = std::max(dark + per_grey * static_cast<float>(row[x]), unrest);
      uu[x] += weight * weight * variance;
      uv[x] += weight * moment * variance;
      vv[x] += moment * moment * variance;
    }
  }
  Row moment2{}, both{}, weight2{};
  for (int x = 0; x < kLanes; ++x) {
    moment2[x] = along_u.moment[x] * along_u.moment[x];
    both[x] = along_u.moment[x] * along_u.weight[x];
    weight2[x] = along_u.weight[x] * along_u.weight[x];
  }
  const Eigen::Vector2d steep(fit.sums.steep_u, fit.sums.steep_v);
  Eigen::Matrix2d covariance;
  covariance << dot(moment2, uu), dot(both, uv), dot(both, uv), dot(weight2, vv);
  return covariance.cwiseQuotient(steep * steep.transpose());
}

}  // namespace

std::optional<MeasuredSpot> spot_centre(const GreyView& on, const GreyView& off, const Eigen::Vector2d& start,
                                        const SpotNoise& noise) {
  const int u0 = static_cast<int>(start.x()), v0 = static_cast<int>(start.y());
  if (u0 < kHalf || v0 < kHalf || u0 + kHalf >= on.width || v0 + kHalf >= on.height) return std::nullopt;
  const bool difference = off.pixels != nullptr;
  Window window{};
  for (int y = 0; y < kSide; ++y) {
    const std::uint8_t* row = on.row(v0 + y - kHalf) + u0 - kHalf;
    for (int x = 0; x < kSide; ++x) window[y][x] = row[x];
    if (!difference) continue;
    row = off.row(v0 + y - kHalf) + u0 - kHalf;
    for (int x = 0; x < kSide; ++x) window[y][x] -= row[x];
  }
  // Near surroundings, for light is uneven; farther ones for spots that reach into them.
  const Eigen::Vector2d begin = start - Eigen::Vector2d(u0, v0);
  std::optional<Fit> fit = fit_spot(window, begin, kNearRim);
  if (!fit || fit->widened(std::max(0.0, 0.5 * fit->spread.trace())) > kLargestOfNear_px * kLargestOfNear_px) {
    fit = fit_spot(window, begin, kHalf);
  }
  if (!fit) return std::nullopt;

  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(fit->spread);
  const double longer = axes.eigenvalues()[1], shorter = axes.eigenvalues()[0];
  if (!(shorter > 0.0) || longer > kMostElongated * kMostElongated * shorter) return std::nullopt;
  float peak = 0;
  for (const Row& row : fit->light) peak = std::max(peak, *std::max_element(row.begin(), row.begin() + kSide));
  if (peak < kLeastOverUnrest * fit->plane.sigma || is_defect(fit->light, on, u0, v0, peak, fit->sums.light)) {
    return std::nullopt;
  }
  return MeasuredSpot{fit->centre + Eigen::Vector2d(u0, v0),
                      covariance_of(*fit, on, u0, v0, difference ? 2.0 : 1.0, noise), std::sqrt(fit->widened(longer)),
                      fit->sums.light};
}

}  // namespace raybundle
