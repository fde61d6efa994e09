// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_lines.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace raybundle {
namespace {

constexpr double kOnLine = 16.0;         // squared sigmas: beyond the 99.9 % point of two degrees of freedom
constexpr int kMinHits = 4;              // two make a line, two more confirm it
constexpr double kMinRangeRatio = 1.25;  // of the hits that a trial line goes through: it interpolates more than not
constexpr int kSeedLines = 24;           // enough for the projector's place
constexpr long kMaxTrials = 20'000'000;  // pairs in the search for seeds
constexpr double kMinShareSeen = 0.5;    // of the views that should show a dot of the line

double range(const BeamHit& hit) { return hit.x_in_rig.norm(); }

Line3 line_between(const BeamHit& near, const BeamHit& far) {
  return {near.x_in_rig, (far.x_in_rig - near.x_in_rig).normalized()};
}

/// A line through two hits, whose own uncertainty grows from the one to the other and beyond.
struct TrialLine {
  TrialLine(const BeamHit& near_hit, const BeamHit& far_hit)
      : near(near_hit),
        far(far_hit),
        line(line_between(near_hit, far_hit)),
        length((far_hit.x_in_rig - near_hit.x_in_rig).norm()) {}

  bool passes(const BeamHit& hit) const {
    constexpr double kFarOff2 = 0.03 * 0.03;  // [m²], cheap to test; a start is better than that
    const Eigen::Vector3d arm = hit.x_in_rig - line.point;
    const double along = arm.dot(line.direction);
    if (arm.squaredNorm() - along * along > kFarOff2) return false;
    const double share = along / length;
    return squared_sigmas(line, hit, (1 - share) * (1 - share) * near.covariance + share * share * far.covariance) <
           kOnLine;
  }

  const BeamHit& near;
  const BeamHit& far;
  Line3 line;
  double length;
};

using HitsOfView = std::map<int, std::vector<int>>;

HitsOfView by_view(const std::vector<BeamHit>& hits) {
  HitsOfView result;
  for (int i = 0; i < static_cast<int>(hits.size()); ++i) result[hits[i].view].push_back(i);
  return result;
}

// Hits that a trial line passes, one for each view; empty as soon as too many views miss the dot they should show.
std::vector<int> supporters(const TrialLine& trial, const LaserBoards& boards, const std::vector<BeamHit>& hits,
                            const HitsOfView& of_view) {
  constexpr int kPatience = 3;
  std::vector<int> found;
  int missed = 0;
  for (const auto& [view, members] : of_view) {
    const auto on_line = std::ranges::find_if(members, [&](int i) { return trial.passes(hits[i]); });
    if (on_line != members.end()) {
      found.push_back(*on_line);
    } else if (boards.expects_dot(view, trial.line)) {
      ++missed;
    }
    if (missed > kPatience && missed > (1 - kMinShareSeen) * static_cast<double>(missed + found.size())) return {};
  }
  return found;
}

// Views in the order of how far away their dots are: lines are tried between the nearest and the farthest.
std::vector<int> views_by_range(const std::vector<BeamHit>& hits, const HitsOfView& of_view) {
  std::vector<std::pair<double, int>> ranges;
  for (const auto& [view, members] : of_view) {
    double sum = 0.0;
    for (int i : members) sum += range(hits[i]);
    ranges.emplace_back(sum / static_cast<double>(members.size()), view);
  }
  std::ranges::sort(ranges);
  std::vector<int> views;
  for (const auto& [mean, view] : ranges) views.push_back(view);
  return views;
}

std::vector<HitLine> seed_lines(const LaserScene& scene, const std::vector<BeamHit>& hits) {
  const LaserBoards boards(scene);
  const HitsOfView of_view = by_view(hits);
  const std::vector<int> views = views_by_range(hits, of_view);
  const int count = static_cast<int>(views.size());
  std::vector<HitLine> seeds;
  std::vector<bool> taken(hits.size(), false);
  long trials = 0;
  for (int reach = count - 1; reach > 0; --reach) {  // the widest differences of range first
    for (int first = 0; first + reach < count; ++first) {
      for (int a : of_view.at(views[first])) {
        for (int b : of_view.at(views[first + reach])) {
          if (taken[a] || taken[b] || range(hits[b]) < kMinRangeRatio * range(hits[a])) continue;
          if (++trials > kMaxTrials) return seeds;
          HitLine line{.line = {}, .hits = supporters({hits[a], hits[b]}, boards, hits, of_view)};
          if (static_cast<int>(line.hits.size()) < 2 * kMinHits && static_cast<int>(line.hits.size()) < count) continue;
          if (static_cast<int>(line.hits.size()) < kMinHits) continue;
          line.line = line_between(hits[a], hits[b]);
          refit(hits, line);
          if (static_cast<int>(line.hits.size()) < kMinHits) continue;
          for (int i : line.hits) taken[i] = true;
          seeds.push_back(std::move(line));
          if (static_cast<int>(seeds.size()) == kSeedLines) return seeds;
        }
      }
    }
  }
  return seeds;
}

/// Where the beams seem to come from, and how far they pass it by.
struct Source {
  Eigen::Vector3d apex = Eigen::Vector3d::Zero();
  double spread_m = 0.0;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Halfway between the places where two lines come nearest to each other; nothing when they are nearly parallel.
std::optional<Eigen::Vector3d> closest_point(const Line3& a, const Line3& b) {
  const double cosine = a.direction.dot(b.direction);
  const double sine2 = 1.0 - cosine * cosine;
  if (sine2 < 1e-4) return std::nullopt;
  const Eigen::Vector3d arm = b.point - a.point;
  const double on_a = (arm.dot(a.direction) - cosine * arm.dot(b.direction)) / sine2;
  const double on_b = (cosine * arm.dot(a.direction) - arm.dot(b.direction)) / sine2;
  return 0.5 * (a.at(on_a) + b.at(on_b));
}

// Median over pairs of lines, then reweighted least squares: a wrong line among the seeds does not count.
std::optional<Source> source_of(const std::vector<HitLine>& lines) {
  std::array<std::vector<double>, 3> places;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t k = i + 1; k < lines.size(); ++k) {
      const std::optional<Eigen::Vector3d> place = closest_point(lines[i].line, lines[k].line);
      for (int axis = 0; place && axis < 3; ++axis) places[axis].push_back((*place)[axis]);
    }
  }
  if (places[0].empty()) return std::nullopt;
  Source source;
  source.apex << median(places[0]), median(places[1]), median(places[2]);
  std::vector<double> distances(lines.size());
  for (int iteration = 0; iteration < 10; ++iteration) {
    for (std::size_t i = 0; i < lines.size(); ++i) distances[i] = distance_between(lines[i].line, source.apex);
    source.spread_m = std::max(1e-4, median(distances));
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const Line3& line = lines[i].line;
      const double weight = 1.0 / (1.0 + std::pow(distances[i] / source.spread_m, 2));
      const Eigen::Matrix3d across_line = Eigen::Matrix3d::Identity() - line.direction * line.direction.transpose();
      normal += weight * across_line;
      right += weight * across_line * line.point;
    }
    source.apex = normal.ldlt().solve(right);
  }
  return source;
}

/// Hits as seen from the source, sorted so that those in nearly the same direction are found quickly.
class Directions {
 public:
  Directions(const std::vector<BeamHit>& hits, const Source& source) : order_(hits.size()) {
    constexpr double kSpreads = 4.0;  // lines pass the apex by up to this many median distances
    for (const BeamHit& hit : hits) {
      const Eigen::Vector3d arm = hit.x_in_rig - source.apex;
      directions_.push_back(arm.normalized());
      ranges_.push_back(arm.norm());
      widths_.push_back((kSpreads * source.spread_m + 3.0 * std::sqrt(hit.covariance.trace())) / arm.norm());
    }
    widest_ = *std::ranges::max_element(widths_);
    std::iota(order_.begin(), order_.end(), 0);
    std::ranges::sort(order_, {}, [&](int i) { return std::pair(directions_[i].x(), i); });
  }

  double range(int hit) const { return ranges_[hit]; }

  std::vector<int> near(int hit) const {
    const double reach = widths_[hit] + widest_;
    const auto x = [&](int i) { return directions_[i].x(); };
    const auto begin = std::ranges::lower_bound(order_, directions_[hit].x() - reach, {}, x);
    std::vector<int> found;
    for (auto i = begin; i != order_.end() && x(*i) <= directions_[hit].x() + reach; ++i) {
      const double width = widths_[hit] + widths_[*i];
      if ((directions_[*i] - directions_[hit]).squaredNorm() < width * width) found.push_back(*i);
    }
    return found;
  }

 private:
  std::vector<Eigen::Vector3d> directions_;
  std::vector<double> ranges_;
  std::vector<double> widths_;
  double widest_ = 0.0;
  std::vector<int> order_;
};

// The line through `hit` and one of the candidates on which most views agree.
HitLine best_line(int hit, const std::vector<int>& candidates, const std::vector<BeamHit>& hits,
                  const Directions& directions) {
  HitLine best;
  for (int other : candidates) {
    if (directions.range(hit) < kMinRangeRatio * directions.range(other)) continue;
    const TrialLine trial(hits[other], hits[hit]);
    std::vector<int> found;
    for (int i : candidates) {
      if (trial.passes(hits[i]) && (found.empty() || hits[found.back()].view != hits[i].view)) found.push_back(i);
    }
    if (found.size() > best.hits.size()) best = {trial.line, std::move(found)};
  }
  return best;
}

}  // namespace

void refit(const std::vector<BeamHit>& hits, HitLine& line) {
  for (int iteration = 0; iteration < 4; ++iteration) {
    const auto count = static_cast<Eigen::Index>(line.hits.size());
    if (count < 2) return;
    Eigen::Matrix3Xd points(3, count);
    Eigen::ArrayXd weights(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const BeamHit& hit = hits[line.hits[i]];
      const Eigen::Matrix<double, 3, 2> basis = across(line.line.direction);
      points.col(i) = hit.x_in_rig;
      weights[i] = 1.0 / (basis.transpose() * hit.covariance * basis).trace();
    }
    line.line = line_through(points, weights, line.line.direction);
    if (std::erase_if(line.hits, [&](int i) { return squared_sigmas(line.line, hits[i]) > 2 * kOnLine; }) == 0) return;
  }
}

std::vector<HitLine> lines_through_hits(const LaserScene& scene, const std::vector<BeamHit>& hits) {
  const std::vector<HitLine> seeds = seed_lines(scene, hits);
  const std::optional<Source> source = source_of(seeds);
  if (!source) return {};
  const Directions directions(hits, *source);
  std::vector<int> far_first(hits.size());
  std::iota(far_first.begin(), far_first.end(), 0);
  std::ranges::sort(far_first, {}, [&](int i) { return std::pair(-directions.range(i), i); });
  std::vector<bool> taken(hits.size(), false);
  std::vector<HitLine> lines;
  for (int hit : far_first) {
    if (taken[hit]) continue;
    std::vector<int> candidates = directions.near(hit);
    std::erase_if(candidates, [&](int i) { return taken[i]; });
    std::ranges::sort(candidates);  // by view
    HitLine line = best_line(hit, candidates, hits, directions);
    refit(hits, line);
    if (static_cast<int>(line.hits.size()) < kMinHits) continue;
    if ((line.line.point - source->apex).dot(line.line.direction) < 0.0) line.line.direction *= -1.0;
    for (int i : line.hits) taken[i] = true;
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace raybundle
