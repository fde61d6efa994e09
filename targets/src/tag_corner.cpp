// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "tag_corner.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "grey_at.hpp"

namespace raybundle {
namespace {

constexpr double kFirstShare = 0.08;  // of the side: the part near the corner is rounded by blur
constexpr double kLastShare = 0.55;   // beyond, a bent side leaves the line
constexpr double kWeakestStep = 8.0;  // grey values across an edge
constexpr double kWorstLine_px = 0.5;

// Centroid of positive slopes under a round window that is moved onto it: where the window begins does not show.
double centred(const std::vector<double>& slopes, double start) {
  constexpr double kWindow = 6.0;  // samples to its edge, 3 px: the slope of a lens that is not plainly out of focus
  constexpr int kMostSteps = 20;
  double centre = start;
  for (int step = 0; step < kMostSteps; ++step) {
    double sum = 0.0;
    double moment = 0.0;
    const int last = std::min(static_cast<int>(slopes.size()) - 1, static_cast<int>(centre + kWindow));
    for (int i = std::max(0, static_cast<int>(std::ceil(centre - kWindow))); i <= last; ++i) {
      const double inside = 1.0 - std::pow((i - centre) / kWindow, 2);
      const double weight = inside * inside * std::max(0.0, slopes[i]);
      sum += weight;
      moment += weight * i;
    }
    const double before = std::exchange(centre, moment / sum);
    if (std::abs(centre - before) < 1e-3) break;
  }
  return centre;
}

// Middle of the steepest rise along `outward` through `place`: where dark turns to bright.
std::optional<double> edge_offset(const cv::Mat& gray, const Eigen::Vector2d& place, const Eigen::Vector2d& outward,
                                  double reach_px) {
  constexpr double kStep_px = 0.5;
  const int half = std::max(3, static_cast<int>(std::ceil(reach_px / kStep_px)));
  std::vector<double> values;
  for (int i = -half - 1; i <= half + 1; ++i) {
    const double value = grey_at(gray, place + i * kStep_px * outward);
    if (value < 0.0) return std::nullopt;
    values.push_back(value);
  }
  std::vector<double> slopes;
  for (std::size_t i = 1; i + 1 < values.size(); ++i) slopes.push_back(values[i + 1] - values[i - 1]);
  const auto steepest = std::ranges::max_element(slopes);
  if (*steepest < kWeakestStep) return std::nullopt;
  return (centred(slopes, static_cast<double>(steepest - slopes.begin())) - half) * kStep_px;
}

struct Line {
  Eigen::Vector2d normal;
  double distance = 0.0;  // normal · x = distance
  double sigma_px = 0.0;  // of the distance, extrapolated to the corner
};

std::optional<Line> fit_side(const cv::Mat& gray, const Eigen::Vector2d& start, const Eigen::Vector2d& along,
                             const Eigen::Vector2d& inward, double reach_px) {
  Eigen::Vector2d outward(along.y(), -along.x());
  if (outward.dot(inward) > 0.0) outward = -outward;
  outward.normalize();
  const double length = along.norm();
  const int samples = std::max(4, static_cast<int>((kLastShare - kFirstShare) * length));
  std::vector<Eigen::Vector2d> offsets;  // distance along the side, offset across it
  for (int i = 0; i < samples; ++i) {
    const double t = kFirstShare + (kLastShare - kFirstShare) * i / (samples - 1);
    if (const auto offset = edge_offset(gray, start + t * along, outward, reach_px)) {
      offsets.emplace_back(t * length, *offset);
    }
  }
  if (2 * offsets.size() < static_cast<std::size_t>(samples) || offsets.size() < 4) return std::nullopt;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& o : offsets) {
    const Eigen::Vector2d row(1.0, o.x());
    normal += row * row.transpose();
    right += o.y() * row;
  }
  const Eigen::Matrix2d inverse = normal.inverse();
  const Eigen::Vector2d line = inverse * right;
  double squares = 0.0;
  for (const Eigen::Vector2d& o : offsets) squares += std::pow(o.y() - line[0] - line[1] * o.x(), 2);
  const double variance = squares / static_cast<double>(offsets.size() - 2);
  if (!(variance < kWorstLine_px * kWorstLine_px)) return std::nullopt;
  const Eigen::Vector2d direction = along.normalized() + line[1] * outward;
  Line fitted;
  fitted.normal = Eigen::Vector2d(direction.y(), -direction.x()).normalized();
  fitted.distance = fitted.normal.dot(start + line[0] * outward);
  constexpr double kFloor_px = 0.03;  // blur that differs on the two sides, and the side's bend
  fitted.sigma_px = std::sqrt(variance * inverse(0, 0) + kFloor_px * kFloor_px);
  return fitted;
}

}  // namespace

std::optional<TagCorner> refine_tag_corner(const cv::Mat& gray, const Eigen::Vector2d& start,
                                           const Eigen::Vector2d& inward_x, const Eigen::Vector2d& inward_y,
                                           double reach_px) {
  Eigen::Vector2d pixel = start;
  double sigma_px = 0.0;
  for (int round = 0; round < 2; ++round) {
    const double reach = round == 0 ? reach_px : std::min(reach_px, 3.0);
    const auto a = fit_side(gray, pixel, inward_x, inward_y, reach);
    const auto b = fit_side(gray, pixel, inward_y, inward_x, reach);
    if (!a || !b) return std::nullopt;
    Eigen::Matrix2d normals;
    normals << a->normal.transpose(), b->normal.transpose();
    const double sine = std::abs(normals.determinant());
    if (sine < 0.2) return std::nullopt;
    pixel = normals.inverse() * Eigen::Vector2d(a->distance, b->distance);
    sigma_px = std::sqrt(0.5 * (a->sigma_px * a->sigma_px + b->sigma_px * b->sigma_px)) / sine;
    if (!((pixel - start).norm() <= reach_px)) return std::nullopt;
  }
  return TagCorner{pixel, sigma_px};
}

}  // namespace raybundle
