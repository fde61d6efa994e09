// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_lines.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "beam_source.hpp"

namespace raybundle {
namespace {

constexpr double kOnLine = 16.0;         // squared sigmas: beyond the 99.9 % point of two degrees of freedom
constexpr int kMinHits = 4;              // two make a line, two more confirm it
constexpr double kMinRangeRatio = 1.25;  // of the hits that a trial line goes through: it interpolates more than not
constexpr int kManyHits = 6;             // of a line that chance hardly makes
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

// Whether the views that should show a dot of the line do so mostly.
bool seen_mostly(const Line3& line, const std::vector<int>& on_line, const LaserBoards& boards,
                 const std::vector<BeamHit>& hits, const HitsOfView& of_view) {
  int missed = 0;
  std::size_t next = 0;  // hits on the line are in the order of their views
  for (const auto& [view, members] : of_view) {
    if (next < on_line.size() && hits[on_line[next]].view == view) {
      ++next;
    } else {
      missed += boards.expects_dot(view, line);
    }
  }
  return static_cast<double>(on_line.size()) >= kMinShareSeen * static_cast<double>(on_line.size() + missed);
}

// Hits that a trial line passes, one for each view; empty when they are few or too many views miss the dot they should
// show.
std::vector<int> supporters(const TrialLine& trial, const LaserBoards& boards, const std::vector<BeamHit>& hits,
                            const HitsOfView& of_view) {
  std::vector<int> found;
  int left = static_cast<int>(of_view.size());
  for (const auto& [view, members] : of_view) {
    const auto on_line = std::ranges::find_if(members, [&](int i) { return trial.passes(hits[i]); });
    if (on_line != members.end()) found.push_back(*on_line);
    if (static_cast<int>(found.size()) + --left < kMinHits) return {};
  }
  return seen_mostly(trial.line, found, boards, hits, of_view) ? found : std::vector<int>{};
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

/// Search for lines by pairs of hits. Those with many hits are taken at once; the others are kept to choose from.
class SeedSearch {
 public:
  SeedSearch(const LaserScene& scene, const std::vector<BeamHit>& hits)
      : hits_(hits), boards_(scene), of_view_(by_view(hits)), taken_(hits.size(), false) {}

  std::vector<HitLine> run() {
    const std::vector<int> views = views_by_range(hits_, of_view_);
    const int count = static_cast<int>(views.size());
    for (int reach = count - 1; reach > 0; --reach) {  // the widest differences of range first
      for (int first = 0; first + reach < count && !enough(); ++first) {
        try_views(of_view_.at(views[first]), of_view_.at(views[first + reach]));
      }
    }
    take_longest();
    return std::move(seeds_);
  }

 private:
  bool enough() const { return static_cast<int>(seeds_.size()) >= kSeedLines || trials_ > kMaxTrials; }

  void try_views(const std::vector<int>& near, const std::vector<int>& far) {
    for (int a : near) {
      for (int b : far) {
        if (taken_[a] || taken_[b] || range(hits_[b]) < kMinRangeRatio * range(hits_[a])) continue;
        ++trials_;
        HitLine line{.line = line_between(hits_[a], hits_[b]),
                     .hits = supporters({hits_[a], hits_[b]}, boards_, hits_, of_view_)};
        if (static_cast<int>(line.hits.size()) < kMinHits) continue;
        refit(hits_, line);
        if (static_cast<int>(line.hits.size()) >= kManyHits) {
          take(line);
        } else if (static_cast<int>(line.hits.size()) >= kMinHits) {
          short_lines_.push_back(std::move(line));
        }
        if (enough()) return;
      }
    }
  }

  void take(const HitLine& line) {
    for (int i : line.hits) taken_[i] = true;
    seeds_.push_back(line);
  }

  void take_longest() {
    std::ranges::stable_sort(short_lines_, std::ranges::greater{},
                             [](const HitLine& line) { return line.hits.size(); });
    for (const HitLine& line : short_lines_) {
      if (enough()) return;
      if (std::ranges::none_of(line.hits, [&](int i) { return taken_[i]; })) take(line);
    }
  }

  const std::vector<BeamHit>& hits_;
  LaserBoards boards_;
  HitsOfView of_view_;
  std::vector<bool> taken_;
  std::vector<HitLine> seeds_;
  std::vector<HitLine> short_lines_;
  long trials_ = 0;
};

/// Hits as seen from the source, sorted so that those in nearly the same direction are found quickly.
class Directions {
 public:
  Directions(const std::vector<BeamHit>& hits, const BeamSource& source) : order_(hits.size()) {
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

/// Shares the hits out to lines once the source is known.
class LineSearch {
 public:
  LineSearch(const LaserScene& scene, const std::vector<BeamHit>& hits, const BeamSource& source)
      : hits_(hits),
        source_(source),
        boards_(scene),
        of_view_(by_view(hits)),
        directions_(hits, source),
        taken_(hits.size(), false) {}

  std::vector<HitLine> run() {
    std::vector<int> far_first(hits_.size());
    std::iota(far_first.begin(), far_first.end(), 0);
    std::ranges::sort(far_first, {}, [&](int i) { return std::pair(-directions_.range(i), i); });
    for (int hit : far_first) {
      if (!taken_[hit]) take_line_through(hit);
    }
    for (int hit : far_first) {
      if (!taken_[hit]) take_line_from_source(hit);
    }
    return std::move(lines_);
  }

 private:
  std::vector<int> free_hits_near(int hit) const {
    std::vector<int> candidates = directions_.near(hit);
    std::erase_if(candidates, [&](int i) { return taken_[i]; });
    std::ranges::sort(candidates);  // by view
    return candidates;
  }

  void take(HitLine line) {
    for (int i : line.hits) taken_[i] = true;
    lines_.push_back(std::move(line));
  }

  void take_line_through(int hit) {
    HitLine line = best_line(hit, free_hits_near(hit), hits_, directions_);
    refit(hits_, line);
    if (static_cast<int>(line.hits.size()) < kMinHits) return;
    if ((line.line.point - source_.apex).dot(line.line.direction) < 0.0) line.line.direction *= -1.0;
    take(std::move(line));
  }

  // The source stands in for the hits that the line lacks.
  void take_line_from_source(int hit) {
    constexpr double kSigmas = 2.0;  // of the apex, in median distances: the beams at the rim pass it by farther
    constexpr std::size_t kFewestHits = 2;
    const double sigma_m = kSigmas * source_.spread_m;
    const BeamHit apex{
        .view = -1, .dot = -1, .x_in_rig = source_.apex, .covariance = sigma_m * sigma_m * Eigen::Matrix3d::Identity()};
    const TrialLine trial(apex, hits_[hit]);
    HitLine line{.line = trial.line, .hits = {}, .leans_on_source = true};
    for (int i : free_hits_near(hit)) {
      const bool first_of_view = line.hits.empty() || hits_[line.hits.back()].view != hits_[i].view;
      if (first_of_view && trial.passes(hits_[i])) line.hits.push_back(i);
    }
    if (line.hits.size() < kFewestHits || !seen_mostly(line.line, line.hits, boards_, hits_, of_view_)) return;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (int i : line.hits) middle += hits_[i].x_in_rig / static_cast<double>(line.hits.size());
    line.line = {middle, (middle - source_.apex).normalized()};
    take(std::move(line));
  }

  const std::vector<BeamHit>& hits_;
  const BeamSource& source_;
  LaserBoards boards_;
  HitsOfView of_view_;
  Directions directions_;
  std::vector<bool> taken_;
  std::vector<HitLine> lines_;
};

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
  std::vector<Line3> seeds;
  for (const HitLine& line : SeedSearch(scene, hits).run()) seeds.push_back(line.line);
  const std::optional<BeamSource> source = source_of(seeds);
  return source ? LineSearch(scene, hits, *source).run() : std::vector<HitLine>{};
}

}  // namespace raybundle
