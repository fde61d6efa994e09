// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/attributes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "raybundle/occupancy/box.hpp"
#include "raybundle/occupancy/zones.hpp"

namespace raybundle {
namespace {

constexpr double kPrior = 0.3, kPriorRays = 1.0;  // of a part that no ray saw
constexpr double kReliefPrior = 0.05;
constexpr double kMiddle_m = 0.14, kHalfWidth_m = 0.30;

// Stripes over x cells, from the bight; the middle of the seat and its sides apart.
struct Profile {
  std::span<const double> heights_m, lengths_m;
  int every;  // of so many rays one is asked

  constexpr int size() const { return 2 * static_cast<int>((heights_m.size() - 1) * (lengths_m.size() - 1)); }

  void add(const SeatPose& seat, const Scan& scan, Attributes& attributes, int& at) const {
    for (std::size_t i = 0; i + 1 < heights_m.size(); ++i) {
      for (std::size_t j = 0; j + 1 < lengths_m.size(); ++j) {
        const auto counted = [&](double right, double left) {
          return count_rays({.origin = {seat.bight.x(), 0, seat.bight.y()},
                             .pitch_rad = 0.0,
                             .low = {lengths_m[j], right, heights_m[i]},
                             .high = {lengths_m[j + 1], left, heights_m[i + 1]}},
                            scan, every);
        };
        BoxCount sides = counted(-kHalfWidth_m, -kMiddle_m);
        sides += counted(kMiddle_m, kHalfWidth_m);
        attributes[at++] = counted(-kMiddle_m, kMiddle_m).filled(kPrior, kPriorRays);
        attributes[at++] = sides.filled(kPrior, kPriorRays);
      }
    }
  }
};

// How far before the surface of the empty seat the rays end: for places on the seat, what the rays towards them and
// near them say, the nearer in angle the more.
struct Relief {
  std::span<const double> along_cushion_m, up_back_m, across_m;
  double blur_rad;
  int every;

  constexpr int size() const { return static_cast<int>((along_cushion_m.size() + up_back_m.size()) * across_m.size()); }

  double before(const Eigen::Vector3d& place, const Scan& scan) const {
    const Eigen::Vector3d to_place = place - scan.viewpoint_in_vehicle;
    const double distance = to_place.norm();
    double sum = 0.0, weight = kReliefPrior;
    for (std::size_t i = 0; i < scan.points.size(); i += static_cast<std::size_t>(every)) {
      const Eigen::Vector3d to_point = scan.points[i].x_in_vehicle - scan.viewpoint_in_vehicle;
      const double range = to_point.norm(), cosine = to_point.dot(to_place) / (range * distance);
      const double exponent = (1.0 - cosine) / (blur_rad * blur_rad);  // half the squared angle over the variance
      if (exponent > 8.0) continue;
      const double w = std::exp(-exponent);
      sum += w * std::clamp(distance - range, -0.3, 0.6);
      weight += w;
    }
    return sum / weight;
  }

  void add(const SeatPose& seat, const Scan& scan, Attributes& attributes, int& at) const {
    for (const double across : across_m) {
      const auto add_place = [&](const Eigen::Vector2d& place) {
        attributes[at++] = before({place.x(), across, place.y()}, scan);
      };
      for (const double along : along_cushion_m) add_place(seat.bight + along * seat.cushion_forward());
      for (const double up : up_back_m) add_place(seat.bight + up * seat.back_up());
    }
  }
};

constexpr double kStripeHeights[] = {-0.10, 0.07, 0.26, 0.46, 0.95};
constexpr double kStripeLengths[] = {-0.30, 0.02, 0.14, 0.26, 0.38, 0.50, 0.66, 0.82};
constexpr int kDenseEvery = 4;
constexpr Profile kSparseProfile{kStripeHeights, kStripeLengths, 1},
    kDenseProfile{kStripeHeights, kStripeLengths, kDenseEvery};
constexpr double kReliefAlong[] = {0.06, 0.18, 0.30, 0.42, 0.54, 0.68};
constexpr double kReliefUp[] = {0.10, 0.25, 0.40, 0.55, 0.72};
constexpr double kReliefAcross[] = {-0.20, -0.10, 0.0, 0.10, 0.20};
constexpr Relief kSparseRelief{kReliefAlong, kReliefUp, kReliefAcross, 0.05, 1};
constexpr Relief kDenseRelief{kReliefAlong, kReliefUp, kReliefAcross, 0.03, kDenseEvery};

// Rays that end before the dashboard, near it and farther away, from the knees up; one of them may be a hand. For dense
// points, also how near to the dashboard they come.
struct Reach {
  double most;        ///< rays; more tell no more
  ZoneOptions zones;  ///< what is believed to be in them
  bool nearest;       ///< whether the nearest place is told as well
  static constexpr double kDepths_m[] = {0.0, 0.20, 0.40, 0.60}, kHeights_m[] = {-0.10, 0.0, 0.12, 0.45};
  static constexpr double kBeside_m = 0.08;  // heights from the zones' floor, and this beyond their sides
  static constexpr double kFar_m = 0.80;     // beyond, nothing is near

  constexpr int size() const {
    return static_cast<int>((std::size(kDepths_m) - 1) * (std::size(kHeights_m) - 1)) + (nearest ? 1 : 0);
  }

  void add(const VehicleLayout& layout, const Scan& scan, Attributes& attributes, int& at) const {
    if (nearest) {
      const ZoneCount count = count_zones(layout, scan, zones);
      attributes[at++] = count.anything ? std::min(count.distance_m, kFar_m) : kFar_m;
    }
    for (std::size_t i = 0; i + 1 < std::size(kDepths_m); ++i) {
      for (std::size_t j = 0; j + 1 < std::size(kHeights_m); ++j) {
        const double wide = layout.zone_half_width_m + kBeside_m;
        const Box box{.low = {layout.dashboard_x_m - kDepths_m[i + 1], -wide, layout.zone_floor_m + kHeights_m[j]},
                      .high = {layout.dashboard_x_m - std::max(kDepths_m[i], zones.dashboard_m), wide,
                               layout.zone_floor_m + kHeights_m[j + 1]}};
        attributes[at++] = std::min(1.0, count_rays(box, scan).hits / most);
      }
    }
  }
};
constexpr Reach kSparseReach{4.0, {}, false}, kDenseReach{100.0, kDenseZones, true};

template <const Profile& profile, const Relief& relief, const Reach& reach>
Attributes profile_and_relief(const VehicleLayout& layout, const SeatPose& seat, const Scan& scan) {
  Attributes attributes(profile.size() + relief.size() + reach.size());
  int at = 0;
  reach.add(layout, scan, attributes, at);
  profile.add(seat, scan, attributes, at);
  relief.add(seat, scan, attributes, at);
  return attributes;
}

}  // namespace

constinit const AttributeSet kStripes{"stripes-2", kSparseProfile.size() + kSparseRelief.size() + kSparseReach.size(),
                                      profile_and_relief<kSparseProfile, kSparseRelief, kSparseReach>};
constinit const AttributeSet kBoxes{"boxes-4", kDenseProfile.size() + kDenseRelief.size() + kDenseReach.size(),
                                    profile_and_relief<kDenseProfile, kDenseRelief, kDenseReach>};

const AttributeSet* attribute_set_named(std::string_view name) {
  for (const AttributeSet* set : {&kStripes, &kBoxes}) {
    if (set->name == name) return set;
  }
  return nullptr;
}

}  // namespace raybundle
