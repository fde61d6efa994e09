// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "camera_corners.hpp"

namespace raybundle {
namespace {

template <typename Wanted>
CameraCorners corners_of(const CalibrationProblem& problem, const BundleState& state, int camera,
                         const Wanted& wanted) {
  CameraCorners corners;
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
      corners.rays.push_back(x.normalized());
      corners.pixels.push_back(view.observations[i].pixel);
    }
  }
  return corners;
}

}  // namespace

CameraCorners used_corners(const CalibrationProblem& problem, const BundleState& state, int camera) {
  return corners_of(problem, state, camera, [](ObservationFate fate) { return fate == ObservationFate::kUsed; });
}

CameraCorners right_corners(const CalibrationProblem& problem, const BundleState& state, int camera) {
  return corners_of(problem, state, camera, [](ObservationFate fate) { return fate != ObservationFate::kOutlier; });
}

}  // namespace raybundle
