// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_scan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "occupancy_evaluation.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr int kLearntRays = 22600;  // of rectified pairs of 128x128 pixels; their lenses differ by some hundred
constexpr double kLeastSeen = 0.6;  // share of these rays, below which too little is seen

// Lenses and mounts differ by a few degrees: what any of the learnt pairs shows is kept.
constexpr RayGridOptions kLearnt{
    .rays_per_rad = 128 / (110 * kDegree), .field_x_rad = 116 * kDegree, .field_y_rad = 160 * kDegree};

}  // namespace

StereoScan::StereoScan(const RectifiedCamera& camera, const Rigid3& vehicle_from_rectified)
    : grid_(camera, kLearnt), vehicle_from_rectified_(vehicle_from_rectified) {
  if (grid_.rays() < kLeastSeen * kLearntRays) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("the rectified pair shows {:.0f} % of what cases of stereo were learnt with, which is 110° "
                            "each way; take lenses of that field, or leave out --field",
                            100.0 * grid_.rays() / kLearntRays));
  }
  points_.reserve(static_cast<std::size_t>(grid_.rays()));
}

int StereoScan::rays() const { return std::max(grid_.rays(), kLearntRays); }

// Larger images have smaller sigmas, which the wrong matches and rims that flicker do not follow: a ray has moved when
// it has by as much as those of learnt pairs.
MonitorOptions StereoScan::monitor_options() const {
  MonitorOptions options = monitor_options_of(SensorKind::kStereo);
  options.moved_sigmas *= grid_.pixels();
  return options;
}

Scan StereoScan::of(const StereoFrame& frame) {
  points_.clear();
  const std::span<const StereoPoint> thinned = grid_.thin(frame.points);
  for (int ray = 0; ray < grid_.rays(); ++ray) {
    const StereoPoint& point = thinned[static_cast<std::size_t>(ray)];
    if (point.sigma_m == 0) continue;
    points_.push_back({ray, vehicle_from_rectified_ * Eigen::Vector3d(point.x_m, point.y_m, point.z_m), point.sigma_m});
  }
  return {vehicle_from_rectified_.translation, points_, rays(), frame.state};
}

}  // namespace raybundle::apps
