// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/box.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

// Coordinates in axes that are pitched by an angle of this cosine and sine.
Eigen::Vector3d turned(const Eigen::Vector3d& x, double cosine, double sine) {
  return {cosine * x.x() + sine * x.z(), x.y(), cosine * x.z() - sine * x.x()};
}

}  // namespace

Eigen::Vector3d Box::x_in_box(const Eigen::Vector3d& x_in_vehicle) const {
  return turned(x_in_vehicle - origin, std::cos(pitch_rad), std::sin(pitch_rad));
}

bool Box::contains(const Eigen::Vector3d& x_in_vehicle) const {
  const Eigen::Vector3d x = x_in_box(x_in_vehicle);
  return (x.array() >= low.array()).all() && (x.array() <= high.array()).all();
}

namespace {

// Counts a ray given in the box's axes; the rotation is done once for all rays.
void count(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& to, BoxCount& count) {
  // Slabs: the ray from + t (to - from) is in the box for t in [enter, leave]; it ends at t = 1.
  double enter = 0.0, leave = 1e9;
  for (int i = 0; i < 3; ++i) {
    const double along = to[i] - from[i];
    if (std::abs(along) < 1e-9) {
      if (from[i] < box.low[i] || from[i] > box.high[i]) return;
      continue;
    }
    const double a = (box.low[i] - from[i]) / along, b = (box.high[i] - from[i]) / along;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return;
  ++(enter > 1.0 ? count.blocked : leave < 1.0 ? count.passed : count.hits);
}

}  // namespace

BoxCount count_rays(const Box& box, const Scan& scan, int every) {
  BoxCount counted;
  const double c = std::cos(box.pitch_rad), s = std::sin(box.pitch_rad);
  const Eigen::Vector3d from = turned(scan.viewpoint_in_vehicle - box.origin, c, s);
  for (std::size_t i = 0; i < scan.points.size(); i += static_cast<std::size_t>(every)) {
    count(box, from, turned(scan.points[i].x_in_vehicle - box.origin, c, s), counted);
  }
  return counted;
}

}  // namespace raybundle
