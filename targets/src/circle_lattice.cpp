// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "circle_lattice.hpp"

#include <fmt/format.h>

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>

namespace raybundle {
namespace {

using Cell = std::pair<int, int>;

constexpr double kReachShare = 0.35;  // of the step, from the predicted neighbour
constexpr double kAreaRatio = 2.2;    // between neighbours
constexpr double kCollinear = 0.85;   // cosine between the two steps of a lattice
constexpr double kFewestShare = 0.9;  // of the pattern's circles
constexpr int kShiftRoom = 2;         // cells by which stray blobs may enlarge the lattice's bounds

struct Lattice {
  std::map<Cell, std::size_t> ellipse_at;
};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

bool alike(const Ellipse& a, const Ellipse& b) {
  const double ratio = std::sqrt(a.shape.determinant() / b.shape.determinant());
  return a.dark == b.dark && ratio < kAreaRatio && ratio > 1.0 / kAreaRatio;
}

std::optional<std::size_t> nearest(const std::vector<Ellipse>& ellipses, const Ellipse& like,
                                   const Eigen::Vector2d& place, double reach) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < ellipses.size(); ++i) {
    const double distance = (ellipses[i].centre - place).norm();
    if (distance < reach && alike(ellipses[i], like)) {
      best = i;
      reach = distance;
    }
  }
  return best;
}

// The two shortest independent steps from an ellipse to its like: a basis of the lattice; the second one clockwise.
std::optional<std::array<Eigen::Vector2d, 2>> basis_at(const std::vector<Ellipse>& ellipses, std::size_t seed) {
  std::vector<Eigen::Vector2d> steps;
  for (std::size_t i = 0; i < ellipses.size(); ++i) {
    if (i != seed && alike(ellipses[i], ellipses[seed])) {
      steps.emplace_back(ellipses[i].centre - ellipses[seed].centre);
    }
  }
  const std::size_t count = std::min<std::size_t>(8, steps.size());
  if (count < 2) return std::nullopt;
  std::ranges::partial_sort(steps, steps.begin() + static_cast<std::ptrdiff_t>(count), {},
                            [](const Eigen::Vector2d& step) { return step.squaredNorm(); });
  for (std::size_t i = 1; i < count; ++i) {
    if (std::abs(steps[0].dot(steps[i])) < kCollinear * steps[0].norm() * steps[i].norm()) {
      const Eigen::Vector2d second = cross(steps[0], steps[i]) > 0.0 ? steps[i] : Eigen::Vector2d(-steps[i]);
      return std::array<Eigen::Vector2d, 2>{steps[0], second};
    }
  }
  return std::nullopt;
}

// Of the four places around an ellipse, those where there is one of its like.
int neighbours_of(const std::vector<Ellipse>& ellipses, std::size_t seed) {
  const auto basis = basis_at(ellipses, seed);
  if (!basis) return 0;
  const double reach = kReachShare * std::min((*basis)[0].norm(), (*basis)[1].norm());
  int neighbours = 0;
  for (const Eigen::Vector2d& step : *basis) {
    for (const double sign : {1.0, -1.0}) {
      neighbours += nearest(ellipses, ellipses[seed], ellipses[seed].centre + sign * step, reach).has_value();
    }
  }
  return neighbours;
}

// Ellipses amid others first: a blob beside the board, whose steps lead into it askew, comes too late to take its circles.
std::vector<std::size_t> seeds_of(const std::vector<Ellipse>& ellipses) {
  std::vector<int> neighbours;
  std::vector<std::size_t> seeds;
  for (std::size_t i = 0; i < ellipses.size(); ++i) {
    neighbours.push_back(neighbours_of(ellipses, i));
    seeds.push_back(i);
  }
  std::ranges::stable_sort(seeds, std::greater{}, [&](std::size_t i) { return neighbours[i]; });
  return seeds;
}

// From neighbour to neighbour; each ellipse hands its own steps on to the next.
Lattice grow(const std::vector<Ellipse>& ellipses, std::size_t seed, std::vector<char>& used) {
  struct Open {
    Cell cell;
    std::size_t ellipse;
    std::array<Eigen::Vector2d, 2> basis;
  };
  Lattice lattice;
  const auto basis = basis_at(ellipses, seed);
  used[seed] = 1;
  if (!basis) return lattice;
  std::deque<Open> open{{{0, 0}, seed, *basis}};
  lattice.ellipse_at[{0, 0}] = seed;
  while (!open.empty()) {
    Open here = open.front();
    open.pop_front();
    const Ellipse& ellipse = ellipses[here.ellipse];
    std::vector<std::pair<Cell, std::size_t>> fresh;
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      int count = 0;
      for (const int sign : {1, -1}) {
        const Cell cell(here.cell.first + (axis == 0 ? sign : 0), here.cell.second + (axis == 1 ? sign : 0));
        const auto known = lattice.ellipse_at.find(cell);
        std::optional<std::size_t> next;
        if (known != lattice.ellipse_at.end()) {
          next = known->second;
        } else {
          const double reach = kReachShare * std::min(here.basis[0].norm(), here.basis[1].norm());
          next = nearest(ellipses, ellipse, ellipse.centre + sign * here.basis[axis], reach);
          if (next && used[*next]) next.reset();
          if (next) {
            used[*next] = 1;
            lattice.ellipse_at[cell] = *next;
            fresh.emplace_back(cell, *next);
          }
        }
        if (next) {
          sum += sign * (ellipses[*next].centre - ellipse.centre);
          ++count;
        }
      }
      if (count > 0) here.basis[axis] = sum / count;
    }
    for (const auto& [cell, next] : fresh) open.push_back({cell, next, here.basis});
  }
  return lattice;
}

struct Bounds {
  Cell low{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
  Cell high{std::numeric_limits<int>::min(), std::numeric_limits<int>::min()};
  void add(const Cell& cell) {
    low = {std::min(low.first, cell.first), std::min(low.second, cell.second)};
    high = {std::max(high.first, cell.first), std::max(high.second, cell.second)};
  }
};

// Changes between short bases of one lattice that keep the handedness.
std::vector<std::array<int, 4>> basis_changes() {
  std::vector<std::array<int, 4>> changes;
  for (int a = -1; a <= 1; ++a) {
    for (int b = -1; b <= 1; ++b) {
      for (int c = -1; c <= 1; ++c) {
        for (int d = -1; d <= 1; ++d) {
          if (a * d - b * c == 1) changes.push_back({a, b, c, d});
        }
      }
    }
  }
  return changes;
}

struct Placement {
  std::map<int, std::size_t> ellipse_of;
  bool ambiguous = false;  // shifted by a cell or more it fits as well
};

/// Point ids of a pattern by cell; -1 where it has none.
struct Sheet {
  Bounds bounds;
  std::vector<int> ids;
  explicit Sheet(const std::vector<Cell>& cells) {
    for (const Cell& cell : cells) bounds.add(cell);
    ids.assign(static_cast<std::size_t>(width()) * height(), -1);
    for (std::size_t id = 0; id < cells.size(); ++id) ids[index(cells[id])] = static_cast<int>(id);
  }
  int width() const { return bounds.high.first - bounds.low.first + 1; }
  int height() const { return bounds.high.second - bounds.low.second + 1; }
  std::size_t index(const Cell& cell) const {
    return static_cast<std::size_t>(cell.second - bounds.low.second) * width() + (cell.first - bounds.low.first);
  }
  int at(const Cell& cell) const {
    const bool inside = cell.first >= bounds.low.first && cell.first <= bounds.high.first &&
                        cell.second >= bounds.low.second && cell.second <= bounds.high.second;
    return inside ? ids[index(cell)] : -1;
  }
};

// The pattern laid over the lattice under one change of basis, at the shift where most circles meet.
Placement place(const Lattice& lattice, const Sheet& sheet, const std::array<int, 4>& m) {
  Bounds bounds;
  std::vector<std::pair<Cell, std::size_t>> turned;
  for (const auto& [cell, ellipse] : lattice.ellipse_at) {
    turned.emplace_back(Cell(m[0] * cell.first + m[1] * cell.second, m[2] * cell.first + m[3] * cell.second), ellipse);
    bounds.add(turned.back().first);
  }
  // The pattern's bounds lie in the lattice's, give or take stray blobs and missing circles.
  const auto range = [](int low, int high, int other_low, int other_high) {
    const int a = other_low - low;
    const int b = other_high - high;
    return std::pair(std::min(a, b) - kShiftRoom, std::max(a, b) + kShiftRoom);
  };
  const Bounds& goal = sheet.bounds;
  const auto [x0, x1] = range(bounds.low.first, bounds.high.first, goal.low.first, goal.high.first);
  const auto [y0, y1] = range(bounds.low.second, bounds.high.second, goal.low.second, goal.high.second);
  std::size_t most = 0;
  Cell shift;
  Placement best;
  for (int x = x0; x <= x1; ++x) {
    for (int y = y0; y <= y1; ++y) {
      const auto met = static_cast<std::size_t>(std::ranges::count_if(turned, [&](const auto& entry) {
        return sheet.at({entry.first.first + x, entry.first.second + y}) >= 0;
      }));
      if (met == most) best.ambiguous = true;
      if (met <= most) continue;
      most = met;
      shift = {x, y};
      best.ambiguous = false;
    }
  }
  for (const auto& [cell, ellipse] : turned) {
    const int id = sheet.at({cell.first + shift.first, cell.second + shift.second});
    if (id >= 0) best.ellipse_of.emplace(id, ellipse);
  }
  return best;
}

// How far the board's x axis points to the image's right.
double rightward(const std::vector<Ellipse>& ellipses, const CirclePattern& pattern,
                 const std::map<int, std::size_t>& ellipse_of) {
  Eigen::Vector2d mean_board = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_image = Eigen::Vector2d::Zero();
  const auto n = static_cast<double>(ellipse_of.size());
  for (const auto& [id, i] : ellipse_of) {
    mean_board += pattern.x_in_board[id] / n;
    mean_image += ellipses[i].centre / n;
  }
  Eigen::Vector2d x_axis = Eigen::Vector2d::Zero();
  for (const auto& [id, i] : ellipse_of) {
    x_axis += (pattern.x_in_board[id].x() - mean_board.x()) * (ellipses[i].centre - mean_image);
  }
  return x_axis.x() / std::max(1e-12, x_axis.norm());
}

// The indices of the largest, in ascending order: small blobs are gravel and leaves.
std::vector<std::size_t> largest_of(const std::vector<Ellipse>& ellipses, std::size_t count) {
  std::vector<std::size_t> indices(ellipses.size());
  std::iota(indices.begin(), indices.end(), 0);
  if (ellipses.size() <= count) return indices;
  std::ranges::stable_sort(indices, std::greater{}, [&](std::size_t i) { return ellipses[i].shape.determinant(); });
  indices.resize(count);
  std::ranges::sort(indices);
  return indices;
}

CircleMatch match_of(const std::vector<Ellipse>& ellipses, const CirclePattern& pattern) {
  std::vector<char> used(ellipses.size(), 0);
  Lattice largest;
  for (const std::size_t seed : seeds_of(ellipses)) {
    if (used[seed]) continue;
    Lattice lattice = grow(ellipses, seed, used);
    if (lattice.ellipse_at.size() > largest.ellipse_at.size()) largest = std::move(lattice);
  }
  CircleMatch match;
  const std::size_t fewest =
      static_cast<std::size_t>(std::ceil(kFewestShare * static_cast<double>(pattern.cells.size())));
  const std::size_t seen = largest.ellipse_at.size();
  if (2 * seen < pattern.cells.size()) return match;

  const Sheet sheet(pattern.cells);
  static const std::vector<std::array<int, 4>> changes = basis_changes();
  Placement best;
  double best_rightward = 0.0;
  for (const std::array<int, 4>& change : changes) {
    Placement placement = place(largest, sheet, change);
    if (placement.ellipse_of.size() < std::max<std::size_t>(1, best.ellipse_of.size())) continue;
    const double points_right = rightward(ellipses, pattern, placement.ellipse_of);
    if (placement.ellipse_of.size() > best.ellipse_of.size() || points_right > best_rightward) {
      best_rightward = points_right;
      best = std::move(placement);
    }
  }
  if (best.ellipse_of.size() >= fewest && !best.ambiguous) {
    match.ellipse_of = std::move(best.ellipse_of);
    return match;
  }
  Bounds bounds;
  for (const auto& [cell, ellipse] : largest.ellipse_at) bounds.add(cell);
  const int wide = bounds.high.first - bounds.low.first + 1, high = bounds.high.second - bounds.low.second + 1;
  const bool as_asked = std::minmax(wide, high) == std::minmax(sheet.width(), sheet.height());
  match.hint = fmt::format(
      "{} circles seen in a lattice of {} x {}, where the board has {}: {}", seen, wide, high, pattern.cells.size(),
      as_asked ? "some are hidden, cut by the image's edge, or blurred" : "check columns and rows");
  return match;
}

}  // namespace

CircleMatch match_circles(const std::vector<Ellipse>& ellipses, const CirclePattern& pattern) {
  const std::vector<std::size_t> indices = largest_of(ellipses, kMostEllipses);
  std::vector<Ellipse> some;
  for (const std::size_t i : indices) some.push_back(ellipses[i]);
  CircleMatch match = match_of(some, pattern);
  for (auto& [id, ellipse] : match.ellipse_of) ellipse = indices[ellipse];
  return match;
}

}  // namespace raybundle
