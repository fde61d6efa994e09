// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "laser_dots_fit.hpp"

namespace raybundle {
namespace {

constexpr double kNear = 3.0;             // sigmas of the spot: where its light is
constexpr double kFar = 4.2;              // sigmas: where its background is still looked at
constexpr double kSureReflectance = 8.0;  // sigmas of noise that ambient light must give for its reflectance to count
constexpr double kOutlier = 4.0;          // sigmas
constexpr double kEvenShare = 0.7;        // of the surroundings

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

bool take_even_surface(SpotWindow& window, double amplitude) {
  // A plane through what lies around the spot, by weights that fall to 0 for what is off it.
  std::vector<std::size_t> around;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (!window.near[i]) around.push_back(i);
  }
  if (around.size() < 12) return false;
  std::vector<double> values;
  for (const std::size_t i : around) values.push_back(window.signal[i]);
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  Eigen::Vector3d plane(values[values.size() / 2], 0, 0);
  for (double& value : values) value = std::abs(value - plane[0]);
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  // What is small beside the spot does not matter to it, however sure it is.
  const double tolerance = kOutlier * std::sqrt(window.variance[0]) + 0.1 * amplitude;
  double bound = std::max(tolerance, 3 * values[values.size() / 2]);
  const auto row = [&](std::size_t i) { return Eigen::Vector3d(1, window.x[i], window.y[i]); };
  for (int pass = 0; pass < 5; ++pass) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const std::size_t i : around) {
      const double share = (window.signal[i] - plane.dot(row(i))) / bound;
      if (std::abs(share) >= 1) continue;
      const double weight = std::pow(1 - share * share, 2);
      normal += weight * row(i) * row(i).transpose();
      right += weight * window.signal[i] * row(i);
    }
    if (normal(0, 0) < 4) return false;
    plane = (normal + 1e-9 * Eigen::Matrix3d::Identity()).ldlt().solve(right);
    bound = std::max(tolerance, 0.6 * bound);
  }
  std::size_t even = 0, kept = 0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    const bool on_plane = std::abs(window.signal[i] - plane.dot(row(i))) < tolerance;
    if (!window.near[i]) even += on_plane ? 1 : 0;
    if (!window.near[i] && !on_plane) continue;
    for (std::vector<double>* values_of :
         {&window.x, &window.y, &window.signal, &window.variance, &window.reflectance, &window.background}) {
      (*values_of)[kept] = (*values_of)[i];
    }
    window.near[kept++] = window.near[i];
  }
  for (std::vector<double>* values_of :
       {&window.x, &window.y, &window.signal, &window.variance, &window.reflectance, &window.background}) {
    values_of->resize(kept);
  }
  window.near.resize(kept);
  return static_cast<double>(even) >= kEvenShare * static_cast<double>(around.size());
}

}  // namespace raybundle
