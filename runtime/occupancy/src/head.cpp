// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/head.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "capped_scan.hpp"
#include "head_fit.hpp"
#include "head_surface.hpp"

namespace raybundle {
namespace {

constexpr int kSeeds = 400;        // places that may be the front of a head
constexpr int kAsked = 3000;       // points that are asked about each
constexpr int kCandidates = 10;    // of them that are fitted
constexpr double kApart_m = 0.10;  // between candidates
constexpr double kBeforeZone_m = 0.05, kBelowRoof_m = 0.05;

struct Candidate {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double score = -1.0;
};

bool may_be_there(const VehicleLayout& layout, const SeatPose& seat, const Eigen::Vector3d& x,
                  const HeadOptions& options) {
  const double ahead = x.x() - seat.bight.x(), above = x.z() - seat.bight.y();
  const bool over_front = ahead > options.front_from_m && ahead < options.front_to_m;
  return std::abs(x.y()) < layout.zone_half_width_m - options.least_from_side_m &&
         x.z() < layout.roof_m - kBelowRoof_m && x.x() < layout.dashboard_x_m + kBeforeZone_m &&
         seat.before_back(x) > options.least_before_back_m &&
         above > (over_front ? options.least_above_front_m : options.least_above_bight_m);
}

// What rays say of a ball.
struct BallCount {
  int on = 0, through = 0;    // of all through it, those that end on its front
  int clear = 0, beside = 0;  // of those just beside its upper half, those that end far behind

  double filled() const { return on / std::max(1.0, static_cast<double>(through)); }
  double free() const { return clear / std::max(1.0, static_cast<double>(beside)); }
};

BallCount count_ball(const CappedScan& capped, const Eigen::Vector3d& centre, double radius_m, int every) {
  constexpr double kInside2 = 0.9, kOutside2 = 1.5, kReach2 = 2.9;  // squares of shares of the radius
  const Scan& scan = capped.scan();
  BallCount count;
  const Eigen::Vector3d to_centre = centre - scan.viewpoint_in_vehicle;
  for (std::size_t i = 0; i < scan.points.size(); i += static_cast<std::size_t>(every)) {
    const Eigen::Vector3d to_point = scan.points[i].x_in_vehicle - scan.viewpoint_in_vehicle;
    const double along = to_centre.dot(to_point), range2 = to_point.squaredNorm();
    const double share2 = (to_centre.squaredNorm() - along * along / range2) / (radius_m * radius_m);
    if (along <= 0.0 || share2 > kReach2) continue;
    const double range = std::sqrt(range2), nearest = along / range;
    if (share2 < kInside2) {
      const double off = range - (nearest - radius_m * std::sqrt(1.0 - share2));
      ++count.through;
      count.on += std::abs(off) < 0.02 + 2.0 * capped.sigma_m(scan.points[i]);
    } else if (share2 > kOutside2 && nearest / range * to_point.z() - to_centre.z() > -0.3 * radius_m) {
      ++count.beside;
      count.clear += range > nearest + 0.5 * radius_m;
    }
  }
  return count;
}

// The best ones stay, best first, no two of them near to each other.
void offer(std::array<Candidate, kCandidates>& best, const Candidate& offered) {
  const auto near = std::ranges::find_if(best, [&](const Candidate& candidate) {
    return candidate.score >= 0.0 && (candidate.centre - offered.centre).norm() < kApart_m;
  });
  Candidate& place = near == best.end() ? best.back() : *near;
  if (place.score >= offered.score) return;
  place = offered;
  std::ranges::sort(best, std::greater{}, &Candidate::score);
}

std::array<Candidate, kCandidates> candidates(const VehicleLayout& layout, const SeatPose& seat,
                                              const CappedScan& capped, const HeadOptions& options) {
  const Scan& scan = capped.scan();
  std::array<Candidate, kCandidates> best;
  const double radius_m = options.semi_axes_m.mean();
  const auto centre_behind = [&](const ScenePoint& point) -> Eigen::Vector3d {
    return point.x_in_vehicle + radius_m * (point.x_in_vehicle - scan.viewpoint_in_vehicle).normalized();
  };
  int places = 0, at = 0;
  for (const ScenePoint& point : scan.points) places += may_be_there(layout, seat, centre_behind(point), options);
  const int every_place = std::max(1, places / kSeeds),
            every = std::max(1, static_cast<int>(scan.points.size()) / kAsked);
  for (const ScenePoint& point : scan.points) {
    const Eigen::Vector3d centre = centre_behind(point);
    if (!may_be_there(layout, seat, centre, options) || at++ % every_place != 0) continue;
    const BallCount count = count_ball(capped, centre, radius_m, every);
    if (count.on * every >= options.least_points / 2) offer(best, {centre, count.filled() * count.free()});
  }
  return best;
}

}  // namespace

Head find_head(const VehicleLayout& layout, const SeatPose& seat, const Scan& scan, const HeadOptions& options) {
  const CappedScan capped(scan);
  Head best;
  for (const Candidate& candidate : candidates(layout, seat, capped, options)) {
    if (candidate.score < 0.0) break;
    Head head = fit_head(capped, seat, candidate.centre, options);
    if (!head.found || !may_be_there(layout, seat, head.centre, options)) continue;
    const BallCount count = count_ball(capped, head.centre, head.semi_axes_m.mean(), 1);
    head.filled = count.filled();
    head.clear = count.free();
    const bool believed =
        head.filled >= options.least_filled && head.clear >= options.least_clear && head.misfit <= options.most_misfit;
    if (!believed) continue;
    const HeadSurface surface = surface_of(capped, head, options);
    head.bend_off = surface.bend_off;
    head.pierced = surface.pierced;
    const double bend = std::max(0.0, head.bend_off - options.common_bend_off);
    const bool bends = std::hypot(head.misfit, bend) <= options.most_misfit;
    if (!bends || head.pierced > options.most_pierced) continue;
    if (!best.found || head.centre.z() > best.centre.z()) best = head;
  }
  return best;
}

}  // namespace raybundle
