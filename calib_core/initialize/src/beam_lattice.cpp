// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_lattice.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <queue>

namespace raybundle {
namespace {

using Place = std::pair<int, int>;  // row, column
constexpr Place kSteps[] = {{0, 1}, {0, -1}, {1, 0}, {-1, 0}};
constexpr double kReach = 0.3;  // of a step: how far from the predicted direction a neighbour may be

Place sum(Place a, Place b) { return {a.first + b.first, a.second + b.second}; }
Place opposite(Place step) { return {-step.first, -step.second}; }

// Direction cosines across the mean direction: there the lattice of a bare grating is regular, and a lens bends it
// slowly. The axes are turned as little as possible from the frame's x and y.
Eigen::Matrix2Xd cosines_of(const std::vector<Line3>& lines) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Line3& line : lines) mean += line.direction;
  const Eigen::Matrix3d upright =
      Eigen::Quaterniond::FromTwoVectors(mean.normalized(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Eigen::Matrix2Xd cosines(2, lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) cosines.col(i) = (upright * lines[i].direction).head<2>();
  return cosines;
}

/// Steps of the lattice at a place.
struct Steps {
  Eigen::Vector2d row;
  Eigen::Vector2d column;
  Eigen::Vector2d along(Place step) const { return step.first * row + step.second * column; }
};

std::vector<int> by_distance(const Eigen::Matrix2Xd& cosines, const Eigen::Vector2d& from) {
  std::vector<int> order(cosines.cols());
  for (int i = 0; i < static_cast<int>(order.size()); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](int i) { return std::pair((cosines.col(i) - from).squaredNorm(), i); });
  return order;
}

// The two shortest steps from a line to others that are far from parallel. Both may also be led backwards: only the
// directions matter, and those are turned towards the axes.
std::optional<Steps> steps_at(const Eigen::Matrix2Xd& cosines, int line) {
  constexpr double kMaxCosine = 0.7;  // between the steps: 45°
  const std::vector<int> order = by_distance(cosines, cosines.col(line));
  std::optional<Eigen::Vector2d> first;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const Eigen::Vector2d step = cosines.col(order[i]) - cosines.col(line);
    if (!first) {
      first = step;
    } else if (std::abs(step.normalized().dot(first->normalized())) < kMaxCosine) {
      Steps steps{.row = *first, .column = step};
      if (std::abs(steps.row.normalized().x()) > std::abs(steps.column.normalized().x())) {
        std::swap(steps.row, steps.column);
      }
      if (steps.row.y() < 0) steps.row *= -1;
      if (steps.column.x() < 0) steps.column *= -1;
      return steps;
    }
  }
  return std::nullopt;
}

/// Grows the lattice from one line.
class Growth {
 public:
  explicit Growth(const Eigen::Matrix2Xd& cosines) : cosines_(cosines), taken_(cosines.cols(), false) {}

  const std::map<Place, int>& from(int line, const Steps& steps) {
    put({0, 0}, line, steps);
    while (!border_.empty()) {
      const Place place = border_.front();
      border_.pop();
      for (Place step : kSteps) grow(place, step);
    }
    return lines_;
  }

 private:
  void put(Place place, int line, const Steps& steps) {
    lines_[place] = line;
    taken_[line] = true;
    steps_[place] = steps;
    border_.push(place);
  }

  Eigen::Vector2d at(Place place) const { return cosines_.col(lines_.at(place)); }

  void grow(Place place, Place step) {
    const Place next = sum(place, step);
    if (lines_.contains(next)) return;
    // The last step this way, straight on, knows best how long the next one is.
    const Place before = sum(place, opposite(step));
    const Steps& steps = steps_.at(place);
    const Eigen::Vector2d ahead = lines_.contains(before) ? Eigen::Vector2d(at(place) - at(before)) : steps.along(step);
    const Eigen::Vector2d predicted = at(place) + ahead;
    Eigen::Index found = 0;
    (cosines_.colwise() - predicted).colwise().squaredNorm().minCoeff(&found);
    const int nearest = static_cast<int>(found);
    if ((cosines_.col(nearest) - predicted).norm() > kReach * ahead.norm() || taken_[nearest]) return;
    const Eigen::Vector2d made = cosines_.col(nearest) - at(place);
    Steps updated = steps;
    if (step.first != 0) updated.row = step.first * made;
    if (step.second != 0) updated.column = step.second * made;
    put(next, nearest, updated);
  }

  const Eigen::Matrix2Xd& cosines_;
  std::vector<bool> taken_;
  std::map<Place, int> lines_;
  std::map<Place, Steps> steps_;
  std::queue<Place> border_;
};

// Lines that are not much nearer to a line of more weight than lines are to each other: a beam may have been found
// twice.
std::vector<int> distinct_lines(const Eigen::Matrix2Xd& cosines, const std::vector<double>& weights) {
  constexpr double kTooNear = 0.4;  // of the median distance to the nearest line
  const auto count = static_cast<int>(cosines.cols());
  std::vector<double> nearest(count);
  const auto distances = [&](int i) { return (cosines.colwise() - cosines.col(i)).colwise().norm().eval(); };
  for (int i = 0; i < count; ++i) {
    Eigen::RowVectorXd others = distances(i);
    others[i] = 2.0;
    nearest[i] = others.minCoeff();
  }
  std::vector<double> sorted = nearest;
  std::ranges::nth_element(sorted, sorted.begin() + count / 2);
  std::vector<int> distinct;
  for (int i = 0; i < count; ++i) {
    const Eigen::RowVectorXd others = distances(i);
    bool doubled = false;
    for (int k = 0; k < count && nearest[i] < kTooNear * sorted[count / 2]; ++k) {
      const bool heavier = std::pair(weights[k], k) > std::pair(weights[i], i);
      doubled |= k != i && heavier && others[k] < kTooNear * sorted[count / 2];
    }
    if (!doubled) distinct.push_back(i);
  }
  return distinct;
}

}  // namespace

std::vector<std::optional<LatticePlace>> lattice_places(const std::vector<Line3>& lines,
                                                        const std::vector<double>& weights) {
  std::vector<std::optional<LatticePlace>> places(lines.size());
  if (lines.size() < 4) return places;
  const Eigen::Matrix2Xd all_cosines = cosines_of(lines);
  const std::vector<int> distinct = distinct_lines(all_cosines, weights);
  const Eigen::Matrix2Xd cosines = all_cosines(Eigen::all, distinct);
  const std::vector<int> middle_first = by_distance(cosines, cosines.rowwise().mean());
  std::map<Place, int> best;
  const std::size_t tries = std::min<std::size_t>(8, distinct.size());  // a start beside a gap has steps too long
  for (std::size_t i = 0; i < tries; ++i) {
    const std::optional<Steps> steps = steps_at(cosines, middle_first[i]);
    if (!steps) continue;
    const std::map<Place, int> grown = Growth(cosines).from(middle_first[i], *steps);
    if (grown.size() > best.size()) best = grown;
  }
  for (const auto& [place, line] : best) places[distinct[line]] = LatticePlace{place.first, place.second};
  return places;
}

}  // namespace raybundle
