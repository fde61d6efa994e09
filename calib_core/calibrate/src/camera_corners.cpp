// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "camera_corners.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

// Calls visit(point in the camera, pixel) for each corner of the camera's posed views whose fate is wanted.
template <typename Wanted, typename Visit>
void for_each_corner(const CalibrationProblem& problem, const BundleState& state, int camera, const Wanted& wanted,
                     const Visit& visit) {
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const TargetView& view = problem.views[v];
    if (view.camera != camera || state.pose_of_view[v] < 0) continue;
    const Rigid3 pose = camera_from_target(problem, state, v);
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    for (std::size_t i = 0; i < view.observations.size(); ++i) {
      if (!wanted(state.fates[v][i])) continue;
      const TargetPoint& point = *problem.targets[view.target].find(view.observations[i].point_id);
      Eigen::Vector3d x = rotation * point.x_in_target;
      if (!point.infinitely_far) x += pose.translation;
      visit(x, view.observations[i].pixel);
    }
  }
}

template <typename Wanted>
CameraCorners corners_of(const CalibrationProblem& problem, const BundleState& state, int camera,
                         const Wanted& wanted) {
  CameraCorners corners;
  for_each_corner(problem, state, camera, wanted, [&](const Eigen::Vector3d& x, const Eigen::Vector2d& pixel) {
    corners.rays.push_back(x.normalized());
    corners.pixels.push_back(pixel);
  });
  return corners;
}

bool is_used(ObservationFate fate) { return fate == ObservationFate::kUsed; }
bool may_be_right(ObservationFate fate) { return fate != ObservationFate::kOutlier; }

}  // namespace

CameraCorners used_corners(const CalibrationProblem& problem, const BundleState& state, int camera) {
  return corners_of(problem, state, camera, is_used);
}

CameraCorners right_corners(const CalibrationProblem& problem, const BundleState& state, int camera) {
  return corners_of(problem, state, camera, may_be_right);
}

double farthest_corner_rad(const CalibrationProblem& problem, const BundleState& state, int camera) {
  double cosine = 1.0;
  for_each_corner(problem, state, camera, may_be_right, [&](const Eigen::Vector3d& x, const Eigen::Vector2d&) {
    cosine = std::min(cosine, x.z() / x.norm());
  });
  return std::acos(cosine);
}

}  // namespace raybundle
