// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "marker_map.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <utility>

namespace raybundle {
namespace {

constexpr std::size_t kNeighbours = 10;
constexpr double kCollinear = 1e-3;  // smallest over largest spread of the points, squared
constexpr double kRidge = 1e-4;      // holds the perspective terms of few, noisy points

}  // namespace

std::optional<LocalPrediction> map_at_origin(const std::vector<Eigen::Vector2d>& from,
                                             const std::vector<Eigen::Vector2d>& to,
                                             const std::vector<double>& weights) {
  if (from.size() < 4) return std::nullopt;
  Eigen::Vector2d from_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_mean = Eigen::Vector2d::Zero();
  double from_scale = 0.0;
  double to_scale = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    from_mean += from[i] / static_cast<double>(from.size());
    to_mean += to[i] / static_cast<double>(to.size());
  }
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    from_scale = std::max({from_scale, from[i].norm(), (from[i] - from_mean).norm()});
    to_scale = std::max(to_scale, (to[i] - to_mean).norm());
    spread += (from[i] - from_mean) * (from[i] - from_mean).transpose();
  }
  const Eigen::Vector2d spreads = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvalues();
  if (!(spreads[0] > kCollinear * spreads[1]) || !(to_scale > 0.0)) return std::nullopt;

  // u (g x + h y + 1) = a x + b y + c and the same for v, in coordinates of order one.
  Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> right = Eigen::Matrix<double, 8, 1>::Zero();
  double total_weight = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector2d x = from[i] / from_scale;
    const Eigen::Vector2d u = (to[i] - to_mean) / to_scale;
    for (int k = 0; k < 2; ++k) {
      Eigen::Matrix<double, 8, 1> row = Eigen::Matrix<double, 8, 1>::Zero();
      row.segment<3>(3 * k) << x.x(), x.y(), 1.0;
      row.tail<2>() = -u[k] * x;
      normal += weights[i] * row * row.transpose();
      right += weights[i] * u[k] * row;
    }
    total_weight += weights[i];
  }
  normal.diagonal().tail<2>().array() += kRidge * total_weight;
  const Eigen::Matrix<double, 8, 1> h = normal.ldlt().solve(right);
  if (!h.allFinite()) return std::nullopt;
  const Eigen::Vector2d at_origin(h[2], h[5]);
  Eigen::Matrix2d linear;
  linear << h[0], h[1], h[3], h[4];
  return LocalPrediction{to_mean + to_scale * at_origin,
                         to_scale / from_scale * (linear - at_origin * h.tail<2>().transpose())};
}

void MarkerMap::add(const Eigen::Vector2d& x_in_board, const Eigen::Vector2d& pixel, double weight) {
  points_.push_back({x_in_board, pixel, weight});
}

double MarkerMap::distance(const Eigen::Vector2d& x_in_board) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Point& point : points_) nearest = std::min(nearest, (point.x_in_board - x_in_board).norm());
  return nearest;
}

std::optional<LocalPrediction> MarkerMap::predict(const Eigen::Vector2d& x_in_board, double reach_m) const {
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    order.emplace_back((points_[i].x_in_board - x_in_board).norm(), i);
  }
  // Neighbours on one line do not carry a map: reach further until they do.
  for (std::size_t count = kNeighbours; !order.empty(); count *= 2) {
    const std::size_t n = std::min(count, order.size());
    std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(n));
    if (order.front().first > reach_m) return std::nullopt;
    std::vector<Eigen::Vector2d> from, to;
    std::vector<double> weights;
    for (std::size_t i = 0; i < n; ++i) {
      const Point& point = points_[order[i].second];
      from.emplace_back(point.x_in_board - x_in_board);
      to.push_back(point.pixel);
      const double distance = order[i].first / reach_m;
      weights.push_back(point.weight / (1.0 + distance * distance));
    }
    std::optional<LocalPrediction> map = map_at_origin(from, to, weights);
    if (map || n == order.size()) return map;
  }
  return std::nullopt;
}

}  // namespace raybundle
