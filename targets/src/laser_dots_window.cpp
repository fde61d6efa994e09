// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "laser_dots_fit.hpp"

namespace raybundle {
namespace {

constexpr double kRim = 2.0;              // sigmas
constexpr double kNear = 3.0;             // sigmas of the spot: where its light is
constexpr double kFar = 4.2;              // sigmas: where its background is still looked at
constexpr double kSureReflectance = 8.0;  // sigmas of noise that ambient light must give for its reflectance to count
constexpr double kOutlier = 4.0;          // sigmas
constexpr double kEvenShare = 0.45;       // of the surroundings, at least
constexpr double kUnevenRim = 0.1;        // of the pixels near the spot, at most
constexpr double kRimLight = 0.3;         // of the amplitude, two sigmas out
constexpr double kSmallStep = 0.05;       // of the amplitude

// Reflectance relative to the brightest pixel near the spot; 1 everywhere where ambient light shows too little of it.
void set_reflectance(SpotWindow& window) {
  double most = 0, least = 1e30, variance = 0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (!window.near[i] || window.background[i] - window.black <= most) continue;
    most = window.background[i] - window.black;
    variance = window.variance[i];
  }
  const bool sure = most > kSureReflectance * std::sqrt(variance);
  for (std::size_t i = 0; i < window.size(); ++i) {
    window.reflectance[i] = sure ? std::max(0.0, window.background[i] - window.black) / most : 1.0;
    if (window.near[i]) least = std::min(least, window.reflectance[i]);
  }
  window.contrast = sure ? 1 - least : 0;
  window.reflectance_variance = sure ? variance / 2 / (most * most) : 0;
}

}  // namespace

SpotWindow spot_window(const DotImages& images, const Eigen::Vector2d& pixel, double sigma_px,
                       const std::vector<const Spot*>& others) {
  SpotWindow window;
  window.pair = images.pair();
  window.black = images.black;
  const cv::Point middle(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())));
  window.origin = {middle.x, middle.y};
  const double far = kFar * sigma_px + 0.5;
  const int radius = static_cast<int>(far);
  const int top = std::max(0, middle.y - radius), bottom = std::min(images.on.rows - 1, middle.y + radius);
  const int left = std::max(0, middle.x - radius), right = std::min(images.on.cols - 1, middle.x + radius);
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const double squares = (Eigen::Vector2d(x, y) - pixel).squaredNorm();
      if (squares > far * far) continue;
      window.x.push_back(x - middle.x);
      window.y.push_back(y - middle.y);
      window.signal.push_back(images.signal.at<float>(y, x));
      window.variance.push_back(images.variance.at<float>(y, x));
      window.background.push_back(window.pair ? images.background.at<float>(y, x) : 0);
      window.near.push_back(squares <= std::pow(kNear * sigma_px, 2));
      window.rim.push_back(window.near.back() && squares > std::pow(kRim * sigma_px, 2));
    }
  }
  window.reflectance.assign(window.size(), 1);
  if (window.pair) set_reflectance(window);
  for (const Spot* other : others) {
    for (std::size_t i = 0; i < window.size(); ++i) {
      const double light =
          window.reflectance[i] * other->value(window.origin + Eigen::Vector2d(window.x[i], window.y[i]));
      window.signal[i] -= light;
      if (window.pair) window.variance[i] += images.noise.shot_variance * std::max(0.0, light);
    }
  }
  // One image's variance was taken of a local mean with the spot in it; that of the surroundings is the spot's too.
  if (!window.pair && window.size() > 0) {
    double least = window.variance[0];
    for (const double variance : window.variance) least = std::min(least, variance);
    std::ranges::fill(window.variance, least);
  }
  return window;
}

namespace {

// A plane through what lies around the spot, by weights that fall to 0 for what is off it.
std::optional<Eigen::Vector3d> surface_around(const SpotWindow& window, const std::vector<double>& grey,
                                              double tolerance) {
  std::vector<double> values;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (!window.near[i]) values.push_back(grey[i]);
  }
  if (values.size() < 12) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  Eigen::Vector3d plane(*middle, 0, 0);
  for (double& value : values) value = std::abs(value - plane[0]);
  std::ranges::nth_element(values, middle);
  double bound = std::max(tolerance, 3 * *middle);
  for (int pass = 0; pass < 4; ++pass) {
    Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < window.size(); ++i) {
      if (window.near[i]) continue;
      const Eigen::Vector3d row(1, window.x[i], window.y[i]);
      const double share = (grey[i] - plane.dot(row)) / bound;
      if (std::abs(share) >= 1) continue;
      const double weight = (1 - share * share) * (1 - share * share);
      normal += weight * row * row.transpose();
      right += weight * grey[i] * row;
    }
    if (normal(0, 0) < 4) return std::nullopt;
    plane = normal.ldlt().solve(right);
    bound = std::max(tolerance, 0.6 * bound);
  }
  return plane;
}

void keep(SpotWindow& window, const std::vector<char>& kept) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    for (auto* values :
         {&window.x, &window.y, &window.signal, &window.variance, &window.reflectance, &window.background}) {
      (*values)[count] = (*values)[i];
    }
    window.near[count] = window.near[i];
    window.rim[count++] = window.rim[i];
  }
  for (auto* values :
       {&window.x, &window.y, &window.signal, &window.variance, &window.reflectance, &window.background}) {
    values->resize(count);
  }
  window.near.resize(count);
  window.rim.resize(count);
}

// An edge's blur is a pixel wider than where it is plain.
void drop_blurred_edge(const SpotWindow& window, std::vector<char>& kept) {
  const std::vector<char> plain = kept;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (plain[i]) continue;
    for (std::size_t k = 0; k < window.size(); ++k) {
      const bool beside = std::abs(window.x[k] - window.x[i]) < 1.5 && std::abs(window.y[k] - window.y[i]) < 1.5;
      if (beside && (window.pair || !window.near[k])) kept[k] = 0;
    }
  }
}

}  // namespace

bool take_even_surface(SpotWindow& window, double amplitude, const GreyNoise& noise) {
  // What is small beside the spot does not matter to it, however sure it is.
  const std::vector<double>& grey = window.pair ? window.background : window.signal;
  const double sigma = std::sqrt(window.variance.empty() ? 1.0 : window.variance[0]);
  const double tolerance = kOutlier * sigma + kSmallStep * amplitude;
  const std::optional<Eigen::Vector3d> plane = surface_around(window, grey, tolerance);
  if (!plane) return false;
  std::vector<char> kept(window.size(), 1);
  int around = 0, even = 0, close = 0, uneven = 0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    const double off = grey[i] - plane->dot(Eigen::Vector3d(1, window.x[i], window.y[i]));
    const bool on_plane = std::abs(off) < tolerance;
    if (!window.near[i]) {
      kept[i] = on_plane;
      ++around;
      even += on_plane;
    } else if (window.pair || window.rim[i]) {
      // The spot's own light reaches the rim a little.
      const bool is_even = off > -tolerance && off < tolerance + (window.pair ? 0 : kRimLight * amplitude);
      if (window.pair) kept[i] = is_even;
      ++close;
      uneven += !is_even;
    }
  }
  if (even < kEvenShare * around || uneven > kUnevenRim * close) return false;
  if (even < around) drop_blurred_edge(window, kept);
  if (window.pair) {
    for (std::size_t i = 0; i < window.size(); ++i) {
      window.signal[i] += window.background[i];
      window.variance[i] = noise.variance((*plane)[0]);
    }
    std::ranges::fill(window.reflectance, 1.0);
    window.reflectance_variance = window.contrast = 0;
    window.pair = false;
  }
  keep(window, kept);
  return true;
}

}  // namespace raybundle
