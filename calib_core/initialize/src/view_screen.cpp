// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_screen.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "linear_pose.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kNeighbours = 8;

/// Distance of a corner from the affine prediction of its neighbours over their distance from it: the median-best of
/// the maps through three of them. Infinite is never returned; 0 when the neighbours cannot predict.
double surprise(const std::vector<Eigen::Vector2d>& board, const std::vector<Eigen::Vector2d>& pixels, std::size_t i,
                std::vector<std::pair<double, std::size_t>>& order) {
  order.clear();
  for (std::size_t j = 0; j < board.size(); ++j) {
    if (j != i) order.emplace_back((board[j] - board[i]).squaredNorm(), j);
  }
  const std::size_t count = std::min(kNeighbours, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end());
  const double reach2 = std::max(order[count - 1].first, 1e-30);

  double best_spread = std::numeric_limits<double>::infinity();
  Eigen::Vector2d best_prediction = pixels[i];
  std::vector<double> errors(count);
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      for (std::size_t c = b + 1; c < count; ++c) {
        const Eigen::Vector2d origin = board[order[a].second];
        Eigen::Matrix2d sides;
        sides << board[order[b].second] - origin, board[order[c].second] - origin;
        if (std::abs(sides.determinant()) < 0.05 * reach2) continue;
        Eigen::Matrix2d image;
        image << pixels[order[b].second] - pixels[order[a].second], pixels[order[c].second] - pixels[order[a].second];
        const Eigen::Matrix2d map = image * sides.inverse();
        for (std::size_t k = 0; k < count; ++k) {
          const std::size_t j = order[k].second;
          errors[k] = (pixels[order[a].second] + map * (board[j] - origin) - pixels[j]).squaredNorm();
        }
        const double spread = quantile(errors, 0.7);
        if (spread >= best_spread) continue;
        best_spread = spread;
        best_prediction = pixels[order[a].second] + map * (board[i] - origin);
      }
    }
  }
  std::vector<double> sides_px(count);
  for (std::size_t k = 0; k < count; ++k) sides_px[k] = (pixels[order[k].second] - best_prediction).norm();
  const double spacing = quantile(sides_px, 0.5);
  return spacing > 0 ? (best_prediction - pixels[i]).norm() / spacing : 0.0;
}

}  // namespace

PointsInView screened(const PointsInView& view) {
  if (view.points.size() < 7) return view;  // too few neighbours to outvote a wrong one
  const PrincipalFrame frame = principal_frame(view.points);
  if (frame.collinear() || frame.spread[2] > 0.1 * frame.spread[0]) return view;
  std::vector<Eigen::Vector2d> board(view.points.size());
  for (std::size_t i = 0; i < board.size(); ++i) board[i] = frame.local(view.points[i]).head<2>();

  PointsInView kept;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < board.size(); ++i) {
    if (surprise(board, view.pixels, i, order) > 0.4) continue;
    kept.points.push_back(view.points[i]);
    kept.pixels.push_back(view.pixels[i]);
  }
  return kept.points.size() >= 6 ? kept : view;
}

PointsInView thinned(const PointsInView& view, std::size_t count) {
  const std::size_t size = view.points.size();
  if (size <= count) return view;
  std::vector<std::size_t> chosen;
  for (const Eigen::Vector2d& direction :
       {Eigen::Vector2d(1, 1), Eigen::Vector2d(1, -1), Eigen::Vector2d(-1, 1), Eigen::Vector2d(-1, -1)}) {
    std::size_t extreme = 0;
    for (std::size_t i = 1; i < size; ++i) {
      if (direction.dot(view.pixels[i]) > direction.dot(view.pixels[extreme])) extreme = i;
    }
    chosen.push_back(extreme);
  }
  // Steps of the golden ratio fall on all rows and columns of any grid.
  for (std::size_t k = 0; chosen.size() < count + 4 && k < count; ++k) {
    const double place = std::fmod(0.6180339887498949 * static_cast<double>(k + 1), 1.0);
    chosen.push_back(static_cast<std::size_t>(place * static_cast<double>(size)));
  }
  std::ranges::sort(chosen);
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  PointsInView kept;
  for (const std::size_t i : chosen) {
    kept.points.push_back(view.points[i]);
    kept.pixels.push_back(view.pixels[i]);
  }
  return kept;
}

std::vector<std::size_t> spread_views(const std::vector<PointsInView>& views, std::size_t count) {
  std::vector<std::size_t> chosen;
  if (views.empty()) return chosen;
  std::vector<Eigen::Vector4d> features(views.size());
  double scale = 1e-9;
  for (std::size_t v = 0; v < views.size(); ++v) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    const double n = static_cast<double>(views[v].pixels.size());
    for (const Eigen::Vector2d& pixel : views[v].pixels) mean += pixel / n;
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& pixel : views[v].pixels) covariance += (pixel - mean) * (pixel - mean).transpose() / n;
    features[v] << mean, std::sqrt(covariance(0, 0)), std::sqrt(covariance(1, 1));
    scale = std::max(scale, mean.norm());
  }
  const auto fullest = std::ranges::max_element(views, {}, [](const PointsInView& view) { return view.points.size(); });
  chosen.push_back(static_cast<std::size_t>(fullest - views.begin()));
  const double most = static_cast<double>(fullest->points.size());
  std::vector<double> distance(views.size(), std::numeric_limits<double>::infinity());
  while (chosen.size() < std::min(count, views.size())) {
    std::size_t next = views.size();
    double best = -1.0;
    for (std::size_t v = 0; v < views.size(); ++v) {
      distance[v] = std::min(distance[v], (features[v] - features[chosen.back()]).norm() + 1e-9 * scale);
      const double value = distance[v] * std::sqrt(static_cast<double>(views[v].points.size()) / most);
      if (std::ranges::find(chosen, v) == chosen.end() && value > best) {
        best = value;
        next = v;
      }
    }
    chosen.push_back(next);
  }
  return chosen;
}

}  // namespace raybundle
