// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_screen.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "linear_pose.hpp"
#include "raybundle/camera/lanes.hpp"
#include "raybundle/geometry/target_clones.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kNeighbours = 8;

constexpr double kSurprise = 0.4;  ///< of the distance to the neighbours
constexpr double kAgreeing = 0.7;  ///< of the neighbours, at least, are right

using Points2 = std::vector<Eigen::Vector2d>;

/// Indices of the corners with the largest and smallest x + y and x - y, of equal ones the first; at least four corners.
/// Choices, not branches: along a row of the board nobody can foresee them.
RAYBUNDLE_TARGET_CLONES
std::array<std::size_t, 4> extreme_corners(const Points2& pixels) {
  using Vector = Lanes::Vector;
  constexpr int lanes = Lanes::kCount;
  const Vector none = Vector{} - std::numeric_limits<double>::infinity();
  Vector reach[4] = {none, none, none, none}, index[4] = {};
  for (std::size_t i = 0; i < pixels.size(); i += lanes) {
    const std::size_t first = std::min(i, pixels.size() - lanes);  // the last ones overlap with those before
    const Eigen::Vector2d* p = &pixels[first];
    const Vector x{p[0].x(), p[1].x(), p[2].x(), p[3].x()}, y{p[0].y(), p[1].y(), p[2].y(), p[3].y()};
    const Vector here[4] = {x + y, -(x + y), x - y, -(x - y)};
    const Vector at = Vector{0, 1, 2, 3} + static_cast<double>(first);
    for (int k = 0; k < 4; ++k) {
      const Lanes::Mask farther = here[k] > reach[k];
      reach[k] = farther ? here[k] : reach[k];
      index[k] = farther ? at : index[k];
    }
  }
  std::array<std::size_t, 4> extreme;
  for (std::size_t k = 0; k < 4; ++k) {
    int best = 0;
    for (int lane = 1; lane < lanes; ++lane) {
      const bool tie = reach[k][lane] == reach[k][best] && index[k][lane] < index[k][best];
      if (reach[k][lane] > reach[k][best] || tie) best = lane;
    }
    extreme[k] = static_cast<std::size_t>(index[k][best]);
  }
  return extreme;
}

/// Indices of `count` corners, or of all when there are fewer: the extreme ones, and steps of the golden ratio, which
/// fall on all rows and columns of any grid. No more than asked for: counts are multiples of the lanes.
std::vector<std::size_t> thinned_indices(const PointsInView& view, std::size_t count) {
  const std::size_t size = view.points.size();
  std::vector<std::size_t> chosen;
  if (size <= count) {
    chosen.resize(size);
    std::iota(chosen.begin(), chosen.end(), 0u);
    return chosen;
  }
  thread_local std::vector<char> taken;
  taken.assign(size, 0);
  std::size_t left = count;
  const auto take = [&](std::size_t i) {
    left -= taken[i] == 0 && left > 0;
    taken[i] = 1;
  };
  for (const std::size_t i : extreme_corners(view.pixels)) take(i);
  for (double place = 0.0; left > 0;) {
    place += 0.6180339887498949;
    if (place >= 1.0) place -= 1.0;
    take(static_cast<std::size_t>(place * static_cast<double>(size)));
  }
  chosen.reserve(count);
  for (std::size_t i = 0; i < size; ++i) {
    if (taken[i]) chosen.push_back(i);
  }
  return chosen;
}

PointsInView selected(const PointsInView& view, const std::vector<std::size_t>& indices) {
  PointsInView kept;
  kept.points.reserve(indices.size());
  kept.pixels.reserve(indices.size());
  for (const std::size_t i : indices) {
    kept.points.push_back(view.points[i]);
    kept.pixels.push_back(view.pixels[i]);
  }
  return kept;
}

/// The corners nearest to one on the board, nearest first.
struct Neighbours {
  std::array<std::size_t, kNeighbours> index;
  std::size_t count = 0;
  double reach2 = 0.0;  ///< squared distance of the farthest
};

/// Squared distances of a board's corners from one of them.
RAYBUNDLE_TARGET_CLONES
void squared_distances(const Points2& board, std::size_t from, double* distances2) {
  const double x = board[from].x(), y = board[from].y();
  for (std::size_t j = 0; j < board.size(); ++j) {
    const double dx = board[j].x() - x, dy = board[j].y() - y;
    distances2[j] = dx * dx + dy * dy;
  }
}

Neighbours neighbours_of(const Points2& board, std::size_t i) {
  thread_local std::vector<double> all;
  all.resize(board.size());
  squared_distances(board, i, all.data());
  Neighbours near;
  std::array<double, kNeighbours> distance2;
  distance2.fill(std::numeric_limits<double>::infinity());
  const auto look_at = [&](std::size_t j) {  // insertion: most corners are farther than the last one kept
    const double d2 = all[j];
    if (d2 >= distance2[kNeighbours - 1]) return;
    std::size_t at = near.count < kNeighbours ? near.count++ : kNeighbours - 1;
    for (; at > 0 && distance2[at - 1] > d2; --at) {
      distance2[at] = distance2[at - 1];
      near.index[at] = near.index[at - 1];
    }
    distance2[at] = d2;
    near.index[at] = j;
  };
  for (std::size_t j = 0; j < board.size(); ++j) {
    if (j != i) look_at(j);
  }
  near.reach2 = std::max(distance2[near.count - 1], 1e-30);
  return near;
}

/// Whether one affine map puts the corner and all its neighbours near to where they are: nothing to vote about.
bool plainly_right(const Points2& board, const Points2& pixels, std::size_t i, const Neighbours& near) {
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d product = Eigen::Matrix2d::Zero();
  Eigen::Vector2d board_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d pixel_mean = Eigen::Vector2d::Zero();
  double farthest2 = 0.0;
  for (std::size_t k = 0; k < near.count; ++k) {
    const Eigen::Vector2d side = board[near.index[k]] - board[i];
    const Eigen::Vector2d image = pixels[near.index[k]] - pixels[i];
    square += side * side.transpose();
    product += image * side.transpose();
    board_mean += side;
    pixel_mean += image;
    farthest2 = std::max(farthest2, image.squaredNorm());
  }
  const double count = static_cast<double>(near.count);
  square -= board_mean * board_mean.transpose() / count;
  product -= pixel_mean * board_mean.transpose() / count;
  if (!(square.determinant() > 0.01 * near.reach2 * near.reach2)) return false;
  const Eigen::Matrix2d map = product * square.inverse();
  const Eigen::Vector2d offset = (pixel_mean - map * board_mean) / count;
  const double limit2 = 0.01 * farthest2;
  bool right = offset.squaredNorm() < limit2;
  for (std::size_t k = 0; right && k < near.count; ++k) {
    const std::size_t j = near.index[k];
    right = (offset + map * (board[j] - board[i]) - (pixels[j] - pixels[i])).squaredNorm() < limit2;
  }
  return right;
}

/// Distance of a corner from the affine prediction of its neighbours over their distance from it: the median-best of
/// the maps through three of them. Infinite is never returned; 0 when the neighbours cannot predict.
double surprise(const Points2& board, const Points2& pixels, std::size_t i, const Neighbours& near) {
  double best_spread = std::numeric_limits<double>::infinity();
  Eigen::Vector2d best_prediction = pixels[i];
  std::vector<double> errors(near.count);
  const auto too_many = near.count - static_cast<std::size_t>(kAgreeing * static_cast<double>(near.count - 1));
  for (std::size_t a = 0; a < near.count; ++a) {
    for (std::size_t b = a + 1; b < near.count; ++b) {
      for (std::size_t c = b + 1; c < near.count; ++c) {
        const Eigen::Vector2d& origin = board[near.index[a]];
        const Eigen::Vector2d& origin_px = pixels[near.index[a]];
        Eigen::Matrix2d sides;
        sides << board[near.index[b]] - origin, board[near.index[c]] - origin;
        if (std::abs(sides.determinant()) < 0.05 * near.reach2) continue;
        Eigen::Matrix2d image;
        image << pixels[near.index[b]] - origin_px, pixels[near.index[c]] - origin_px;
        const Eigen::Matrix2d map = image * sides.inverse();
        std::size_t worse = 0;
        for (std::size_t k = 0; worse < too_many && k < near.count; ++k) {
          const std::size_t j = near.index[k];
          errors[k] = (origin_px + map * (board[j] - origin) - pixels[j]).squaredNorm();
          worse += errors[k] >= best_spread;
        }
        if (worse == too_many) continue;  // nor can the quantile be better
        const double spread = quantile(errors, kAgreeing);
        if (spread >= best_spread) continue;
        best_spread = spread;
        best_prediction = origin_px + map * (board[i] - origin);
      }
    }
  }
  std::vector<double> sides_px(near.count);
  for (std::size_t k = 0; k < near.count; ++k) sides_px[k] = (pixels[near.index[k]] - best_prediction).norm();
  const double spacing = median(sides_px);
  return spacing > 0 ? (best_prediction - pixels[i]).norm() / spacing : 0.0;
}

/// The points of a board that a view shows, in their plane, with the neighbours of those that were asked for.
class FlatBoard {
 public:
  explicit FlatBoard(const std::vector<Eigen::Vector3d>& points) : points_(points), neighbours_(points.size()) {
    if (points.size() < 7) return;  // fewer have too few neighbours to outvote a wrong one
    const PrincipalFrame frame = principal_frame(points);
    if (frame.collinear() || frame.spread[2] > 0.1 * frame.spread[0]) return;
    for (const Eigen::Vector3d& point : points) plane_.push_back(frame.local(point).head<2>());
  }

  const std::vector<Eigen::Vector3d>& points() const { return points_; }

  /// Whether the corner lies where its neighbours say, or they can say nothing.
  bool agrees(const Points2& pixels, std::size_t i) {
    if (plane_.empty()) return true;
    if (neighbours_[i].count == 0) neighbours_[i] = neighbours_of(plane_, i);
    const Neighbours& near = neighbours_[i];
    return plainly_right(plane_, pixels, i, near) || surprise(plane_, pixels, i, near) <= kSurprise;
  }

 private:
  std::vector<Eigen::Vector3d> points_;
  Points2 plane_;
  std::vector<Neighbours> neighbours_;
};

PointsInView screened(const PointsInView& view, FlatBoard& board, std::size_t count) {
  const std::vector<std::size_t> candidates = thinned_indices(view, count);
  std::vector<std::size_t> kept;
  for (const std::size_t i : candidates) {
    if (board.agrees(view.pixels, i)) kept.push_back(i);
  }
  return selected(view, kept.size() >= 6 ? kept : candidates);
}

}  // namespace

std::vector<PointsInView> screened(std::span<const PointsInView> views, const std::vector<std::size_t>& chosen,
                                   std::size_t count) {
  std::vector<PointsInView> result;
  std::optional<FlatBoard> board;  // views that show it whole show the same
  for (const std::size_t v : chosen) {
    if (!board || board->points() != views[v].points) board.emplace(views[v].points);
    result.push_back(screened(views[v], *board, count));
  }
  return result;
}

PointsInView thinned(const PointsInView& view, std::size_t count) {
  return view.points.size() <= count ? view : selected(view, thinned_indices(view, count));
}

std::vector<std::size_t> spread_views(std::span<const PointsInView> views, std::size_t count) {
  std::vector<std::size_t> chosen;
  if (views.empty()) return chosen;
  std::vector<Eigen::Vector4d> features(views.size());  // where the corners are and how far they reach
  double scale = 1e-9;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::vector<Eigen::Vector2d>& pixels = views[v].pixels;
    Eigen::Array2d sum = Eigen::Array2d::Zero(), squares = Eigen::Array2d::Zero();
    for (const Eigen::Vector2d& pixel : pixels) {
      const Eigen::Array2d offset = pixel - pixels.front();
      sum += offset;
      squares += offset.square();
    }
    const Eigen::Array2d mean = sum / static_cast<double>(pixels.size());
    const Eigen::Array2d variance = squares / static_cast<double>(pixels.size()) - mean.square();
    features[v] << pixels.front() + mean.matrix(), variance.cwiseMax(0.0).sqrt().matrix();
    scale = std::max(scale, features[v].head<2>().norm());
  }
  const auto fullest = std::ranges::max_element(views, {}, [](const PointsInView& view) { return view.points.size(); });
  chosen.push_back(static_cast<std::size_t>(fullest - views.begin()));
  std::vector<bool> taken(views.size(), false);
  taken[chosen[0]] = true;
  const double most = static_cast<double>(fullest->points.size());
  std::vector<double> distance(views.size(), std::numeric_limits<double>::infinity());
  while (chosen.size() < std::min(count, views.size())) {
    std::size_t next = views.size();
    double best = -1.0;
    for (std::size_t v = 0; v < views.size(); ++v) {
      distance[v] = std::min(distance[v], (features[v] - features[chosen.back()]).norm() + 1e-9 * scale);
      const double value = distance[v] * std::sqrt(static_cast<double>(views[v].points.size()) / most);
      if (!taken[v] && value > best) {
        best = value;
        next = v;
      }
    }
    chosen.push_back(next);
    taken[next] = true;
  }
  return chosen;
}

}  // namespace raybundle
