// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "ellipse.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace raybundle {
namespace {

constexpr double kSmallestArea_px2 = 12.0;
constexpr double kAreaTolerance = 0.12;     // of the area against that of the ellipse with the same moments
constexpr double kOutlineTolerance = 0.25;  // of the outline's distance from the centre
constexpr double kMostElongated = 8.0;
constexpr double kWeakestContrast = 12.0;

// The shorter one first.
Eigen::Vector2d squared_axes(const Eigen::Matrix2d& shape) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(shape).eigenvalues();
}

bool has_both_axes(const Eigen::Vector2d& squared) {
  return squared[0] > 0.0 && squared[1] <= kMostElongated * kMostElongated * squared[0];
}

std::optional<Ellipse> ellipse_of(const std::vector<cv::Point>& outline, bool dark) {
  if (outline.size() < 8) return std::nullopt;
  const cv::Moments moments = cv::moments(outline);
  if (!(moments.m00 >= kSmallestArea_px2)) return std::nullopt;
  Eigen::Matrix2d spread;
  spread << moments.mu20, moments.mu11, moments.mu11, moments.mu02;
  spread /= moments.m00;
  const Eigen::Vector2d spreads = squared_axes(spread);
  if (!has_both_axes(spreads)) return std::nullopt;
  // A filled ellipse has second moments of a quarter of its squared semi-axes.
  Ellipse ellipse;
  ellipse.centre = {moments.m10 / moments.m00, moments.m01 / moments.m00};
  ellipse.shape = 4.0 * spread;
  ellipse.dark = dark;
  const double area = std::numbers::pi * std::sqrt(ellipse.shape.determinant());
  const double half_px = 0.5 / std::sqrt(4.0 * spreads[0]);  // what the pixel grid does to a small blob
  if (std::abs(moments.m00 - area) > (kAreaTolerance + 0.2 * half_px) * area) return std::nullopt;
  const Eigen::Matrix2d inverse = ellipse.shape.inverse();
  for (const cv::Point& point : outline) {
    const Eigen::Vector2d d = Eigen::Vector2d(point.x, point.y) - ellipse.centre;
    if (std::abs(std::sqrt(d.dot(inverse * d)) - 1.0) > kOutlineTolerance + half_px) return std::nullopt;
  }
  return ellipse;
}

std::vector<Ellipse> ellipses_in(const cv::Mat& dark_is_white) {
  std::vector<std::vector<cv::Point>> outlines;
  std::vector<cv::Vec4i> hierarchy;  // next, previous, first child, parent
  cv::findContours(dark_is_white, outlines, hierarchy, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  std::vector<Ellipse> ellipses;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    if (auto ellipse = ellipse_of(outlines[i], hierarchy[i][3] < 0)) ellipses.push_back(*ellipse);
  }
  return ellipses;
}

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

/// Every pixel's gradient spans a line (a, b, c) that touches the ellipse: a²A + abB + b²C + acD + bcE + c² = 0. Least
/// squares for A to E, in places that count from a rough ellipse's centre in units of its scale.
struct Tangents {
  double scale = 1.0;  // [px]
  Matrix5 normal = Matrix5::Zero();
  Vector5 right_side = Vector5::Zero();
  double squares = 0.0;
  double count = 0.0;

  void add(const Eigen::Vector2d& gradient, const Eigen::Vector2d& from_centre_px) {
    const double a = gradient.x();
    const double b = gradient.y();
    const double c = -gradient.dot(from_centre_px) / scale;
    Vector5 terms;
    terms << a * a, a * b, b * b, a * c, b * c;
    // Quadratic in the gradient already; its square root less lets weak places speak a little more.
    const double weight = 1.0 / std::max(1.0, gradient.norm());
    normal += weight * terms * terms.transpose();
    right_side -= weight * c * c * terms;
    squares += weight * c * c * c * c;
    count += 1.0;
  }
};

// By the pixels in a band about the outline; nothing where that leaves the image.
std::optional<Tangents> tangents_about(const cv::Mat& gray, const Ellipse& ellipse) {
  const Eigen::Vector2d semi(std::sqrt(ellipse.shape(0, 0)), std::sqrt(ellipse.shape(1, 1)));
  const Eigen::Matrix2d inverse = ellipse.shape.inverse();
  const double shortest = std::sqrt(squared_axes(ellipse.shape)[0]);
  const double band = std::max(0.3, 2.0 / shortest);
  const Eigen::Vector2d reach = (1.0 + band) * semi;
  const int left = static_cast<int>(std::floor(ellipse.centre.x() - reach.x()));
  const int right = static_cast<int>(std::ceil(ellipse.centre.x() + reach.x()));
  const int top = static_cast<int>(std::floor(ellipse.centre.y() - reach.y()));
  const int bottom = static_cast<int>(std::ceil(ellipse.centre.y() + reach.y()));
  if (left < 1 || top < 1 || right >= gray.cols - 1 || bottom >= gray.rows - 1) return std::nullopt;
  const double sign = ellipse.dark ? 0.5 : -0.5;
  Tangents tangents{.scale = std::max(semi.x(), semi.y())};
  for (int y = top; y <= bottom; ++y) {
    const auto* row = gray.ptr<std::uint8_t>(y);
    const auto* above = gray.ptr<std::uint8_t>(y - 1);
    const auto* below = gray.ptr<std::uint8_t>(y + 1);
    for (int x = left; x <= right; ++x) {
      const Eigen::Vector2d d = Eigen::Vector2d(x, y) - ellipse.centre;
      const double distance = std::sqrt(d.dot(inverse * d));
      if (std::abs(distance - 1.0) > band) continue;
      const Eigen::Vector2d gradient(sign * (row[x + 1] - row[x - 1]), sign * (below[x] - above[x]));
      if (gradient.dot(inverse * d) > 0.0) tangents.add(gradient, d);
    }
  }
  return tangents;
}

// The ellipse that they touch.
//
// @param about  the one about which they were taken
std::optional<Ellipse> ellipse_of(const Tangents& tangents, const Ellipse& about) {
  const Eigen::LDLT<Matrix5> solver(tangents.normal);
  const Vector5 conic = solver.solve(tangents.right_side);
  if (!conic.allFinite()) return std::nullopt;
  const Eigen::Vector2d centre = 0.5 * conic.tail<2>();
  Eigen::Matrix2d shape;
  shape << -conic[0], -0.5 * conic[1], -0.5 * conic[1], -conic[2];
  shape += centre * centre.transpose();
  if (!has_both_axes(squared_axes(shape))) return std::nullopt;
  // Neighbouring gradients share pixels: about a third of the equations are independent.
  const double variance =
      3.0 * std::max(0.0, tangents.squares - conic.dot(tangents.right_side)) / std::max(1.0, tangents.count - 5.0);
  const Matrix5 covariance = variance * solver.solve(Matrix5::Identity());
  constexpr double kFloor_px = 0.015;
  const double scale = tangents.scale;
  const double spread = 0.25 * 0.5 * (covariance(3, 3) + covariance(4, 4)) * scale * scale;
  Ellipse ellipse = about;
  ellipse.centre += scale * centre;
  ellipse.shape = scale * scale * shape;
  ellipse.sigma_px = std::sqrt(spread + kFloor_px * kFloor_px);
  return ellipse;
}

}  // namespace

std::vector<Ellipse> find_ellipses(const cv::Mat& gray, int block_px) {
  constexpr double kBelowMean = 5.0;
  cv::Mat binary;
  cv::adaptiveThreshold(gray, binary, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV, block_px, kBelowMean);
  return ellipses_in(binary);
}

std::optional<Ellipse> find_ellipse_at(const cv::Mat& gray, const Eigen::Vector2d& place, double reach_px) {
  const int reach = static_cast<int>(std::ceil(reach_px));
  const cv::Point middle(static_cast<int>(std::lround(place.x())), static_cast<int>(std::lround(place.y())));
  const cv::Rect window =
      cv::Rect(middle.x - reach, middle.y - reach, 2 * reach + 1, 2 * reach + 1) & cv::Rect(0, 0, gray.cols, gray.rows);
  if (window.width < 5 || window.height < 5) return std::nullopt;
  cv::Mat patch, binary;
  cv::GaussianBlur(gray(window), patch, cv::Size(3, 3), 0.0);
  double low = 0.0;
  double high = 0.0;
  cv::minMaxLoc(patch, &low, &high);
  if (high - low < kWeakestContrast) return std::nullopt;
  cv::threshold(gray(window), binary, 0.5 * (low + high), 255, cv::THRESH_BINARY_INV);
  std::optional<Ellipse> best;
  for (Ellipse& ellipse : ellipses_in(binary)) {
    ellipse.centre += Eigen::Vector2d(window.x, window.y);
    const Eigen::Vector2d d = place - ellipse.centre;
    if (d.dot(ellipse.shape.inverse() * d) > 1.0) continue;
    if (!best || d.norm() < (place - best->centre).norm()) best = ellipse;
  }
  return best;
}

std::optional<Ellipse> refine_ellipse(const cv::Mat& gray, const Ellipse& rough) {
  Ellipse ellipse = rough;
  for (int round = 0; round < 2; ++round) {
    const std::optional<Tangents> tangents = tangents_about(gray, ellipse);
    if (!tangents || tangents->count < 12.0) return std::nullopt;
    const std::optional<Ellipse> touched = ellipse_of(*tangents, ellipse);
    if (!touched) return std::nullopt;
    ellipse = *touched;
    const Eigen::Vector2d moved = ellipse.centre - rough.centre;
    if (!(moved.dot(rough.shape.inverse() * moved) < 0.25)) return std::nullopt;
  }
  const double growth = ellipse.shape.determinant() / rough.shape.determinant();
  if (!(growth > 0.2 && growth < 8.0)) return std::nullopt;
  return ellipse;
}

}  // namespace raybundle
