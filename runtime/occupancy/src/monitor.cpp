// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "raybundle/geometry/error.hpp"
#include "raybundle/occupancy/fixtures.hpp"

namespace raybundle {
namespace {

const AttributeSet* attributes_of(const CaseBase& base) {
  base.check();
  const AttributeSet* set = attribute_set_named(base.attribute_set);
  if (set == nullptr || set->size != base.spaces.front().embedding.attributes()) {
    throw Error(ErrorKind::kBadInput, "the base was learnt with attributes '" + base.attribute_set +
                                          "', which this program does not make; learn it again");
  }
  return set;
}

bool is_of_sensor(const Scan& scan, std::size_t rays) {
  return static_cast<std::size_t>(scan.rays) == rays && scan.points.size() <= rays &&
         std::ranges::all_of(scan.points, [&](const ScenePoint& p) { return p.ray >= 0 && p.ray < scan.rays; });
}

}  // namespace

OccupancyMonitor::OccupancyMonitor(const VehicleLayout& layout, CaseBase base, int rays, const MonitorOptions& options)
    : layout_(layout), base_(std::move(base)), attributes_(attributes_of(base_)), options_(options) {
  if (rays < 1 || options.calm_frames < 1 || options.memory_frames < 1) {
    throw Error(ErrorKind::kBadInput, "a monitor needs at least one ray, one calm frame and one frame of memory");
  }
  last_said_.resize(static_cast<std::size_t>(options.memory_frames));
  clear_.reserve(static_cast<std::size_t>(rays));
  range_m_.resize(static_cast<std::size_t>(rays), NAN);
  last_range_m_ = range_m_;
  restart();
}

void OccupancyMonitor::restart() {
  first_ = true;
  said_ = 0;
  last_actions_.assign(static_cast<std::size_t>(options_.calm_frames) - 1, AirbagAction::kUndecided);
}

Occupancy OccupancyMonitor::process(const Scan& measured, const SeatPose& seat) {
  Occupancy now;
  if (!is_of_sensor(measured, range_m_.size())) {
    restart();
    return now;
  }
  const double share = static_cast<double>(measured.points.size()) / static_cast<double>(range_m_.size());
  const Scan scan = without_fixtures(layout_, measured, options_.zones.dashboard_m, clear_);
  if (scan.state == State::kInvalid || share < options_.least_points) {
    restart();  // what was before the gap says nothing of now
    return now;
  }
  now.state = worse(scan.state, share < options_.good_points ? State::kDegraded : State::kOk);
  now.moving = moving_share(scan);
  now.zones = count_zones(layout_, scan, options_.zones);
  now.free_rays = rays_through_zones(layout_, scan);
  now.verdict = classify(base_, attributes_->attributes(layout_, seat, scan));
  vote(now);
  now.action = calmed(action_of(now));
  if (now.action == AirbagAction::kUndecided) now.state = State::kInvalid;
  return now;
}

// Share of the rays on the seat that ended elsewhere than in the last frame.
double OccupancyMonitor::moving_share(const Scan& scan) {
  std::ranges::fill(range_m_, NAN);
  int both = 0, moved = 0;
  for (const ScenePoint& point : scan.points) {
    const double range = (point.x_in_vehicle - scan.viewpoint_in_vehicle).norm(), last = last_range_m_[point.ray];
    range_m_[point.ray] = range;
    const bool on_seat = std::abs(point.x_in_vehicle.y()) < layout_.zone_half_width_m &&
                         point.x_in_vehicle.x() < layout_.dashboard_x_m - layout_.out_of_position_m / 2;
    if (first_ || !on_seat || !std::isfinite(last)) continue;
    ++both;
    moved += std::abs(range - last) > options_.moved_sigmas * point.sigma_m;
  }
  std::swap(range_m_, last_range_m_);
  first_ = false;
  return both == 0 ? 0.0 : static_cast<double>(moved) / both;
}

// Mean of this frame and of those before it.
OccupancyMonitor::Said OccupancyMonitor::remembered(const Said& now) {
  last_said_[said_++ % last_said_.size()] = now;
  const std::size_t frames = std::min(said_, last_said_.size());
  const double weight = 1.0 / static_cast<double>(frames);
  Said mean;
  for (std::size_t i = 0; i < frames; ++i) {
    for (std::size_t c = 0; c < mean.votes.size(); ++c) mean.votes[c] += weight * last_said_[i].votes[c];
    for (std::size_t a = 0; a < mean.allowed.size(); ++a) mean.allowed[a] += weight * last_said_[i].allowed[a];
  }
  return mean;
}

// What moves is not inert: the votes go to the others.
void OccupancyMonitor::vote(Occupancy& now) {
  allowed_ = now.verdict.allowed_least;
  if (!now.verdict.known) {
    said_ = 0;  // what was before the gap says nothing of what comes after it
    return;
  }
  const Said said = remembered({now.verdict.votes, now.verdict.allowed_least});
  if (options_.dense) allowed_ = said.allowed;
  std::array<double, kMostClasses> votes = said.votes;
  if (now.moving > options_.moving) {
    double left = 0.0;
    for (std::size_t c = 0; c < base_.situations.size(); ++c) {
      if (base_.situations[c].inert) votes[c] = 0.0;
      left += votes[c];
    }
    now.verdict.known = left > 0.0;
    if (!now.verdict.known) return;
    for (double& vote : votes) vote /= left;
  }
  const auto situation = std::ranges::max_element(votes);
  now.confidence = *situation;
  if (*situation >= base_.sure_of_situation) now.situation = static_cast<int>(situation - votes.begin());
  const std::array<double, kMostClasses> groups = group_votes(base_, votes);
  const auto group = std::ranges::max_element(groups);
  if (*group >= base_.sure_of_group) now.group = static_cast<int>(group - groups.begin());
}

// What forbids is said by this frame alone. To fire, every space has to agree, and enough rays must have found the
// zones free: where nothing was seen somebody may be.
AirbagAction OccupancyMonitor::action_of(const Occupancy& now) const {
  if (now.zones.critical > 0) return AirbagAction::kNoFire;
  if (!now.verdict.known) return AirbagAction::kUndecided;
  const double no_fire = now.verdict.action_votes[static_cast<std::size_t>(AirbagAction::kNoFire)];
  if (no_fire >= options_.sure_of_no_fire) return AirbagAction::kNoFire;
  const auto least = [&](AirbagAction action) { return allowed_[static_cast<std::size_t>(action)]; };
  const bool seen = now.free_rays >= options_.least_free * static_cast<double>(range_m_.size());
  if (seen && (options_.dense || now.group >= 0)) {
    if (least(AirbagAction::kFire) >= options_.sure_of_force && now.zones.out_of_position == 0) {
      return AirbagAction::kFire;
    }
    if (least(AirbagAction::kDepowered) >= options_.sure_of_force) return AirbagAction::kDepowered;
  }
  return AirbagAction::kUndecided;
}

// The least forceful of the last frames: what forbids acts at once, what allows has to last without a doubt between.
AirbagAction OccupancyMonitor::calmed(AirbagAction now) {
  AirbagAction least = now;
  for (const AirbagAction before : last_actions_) least = std::min(least, before);
  if (!last_actions_.empty()) {
    std::rotate(last_actions_.begin(), last_actions_.begin() + 1, last_actions_.end());
    last_actions_.back() = now;
  }
  return now == AirbagAction::kNoFire ? now : least;
}

}  // namespace raybundle
