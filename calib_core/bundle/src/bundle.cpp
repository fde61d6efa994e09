// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/bundle.hpp"

#include <cmath>

#include "projected.hpp"

namespace raybundle {
namespace {

// Pixel of each observation of a view; NaN where the model does not project it.
//
// @param points  of the view's target, on its surface
Eigen::MatrixX2d projected_corners(const CalibrationProblem& problem, const BundleState& state, int view,
                                   const std::vector<Eigen::Vector3d>& points) {
  const TargetView& seen = problem.views[view];
  const auto count = static_cast<Eigen::Index>(seen.observations.size());
  if (state.pose_of_view[view] < 0) return Eigen::MatrixX2d::Constant(count, 2, std::nan(""));
  const Target& target = problem.targets[seen.target];
  const Rigid3 pose = camera_from_target(problem, state, view);
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  Eigen::MatrixX3d points_in_camera(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const TargetPoint* point = target.find(seen.observations[static_cast<std::size_t>(i)].point_id);
    Eigen::Vector3d x = rotation * points[point - target.points.data()];
    if (!point->infinitely_far) x += pose.translation;
    points_in_camera.row(i) = x;
  }
  return projected(state.cameras[seen.camera], points_in_camera);
}

std::vector<Eigen::Vector2d> residuals_of(const TargetView& view, const Eigen::MatrixX2d& pixels) {
  std::vector<Eigen::Vector2d> residuals;
  residuals.reserve(view.observations.size());
  for (const Observation& observation : view.observations) {
    residuals.push_back(observation.pixel - pixels.row(static_cast<Eigen::Index>(residuals.size())).transpose());
  }
  return residuals;
}

std::vector<std::vector<Eigen::Vector3d>> surfaces(const CalibrationProblem& problem, const BundleState& state) {
  std::vector<std::vector<Eigen::Vector3d>> points;
  for (std::size_t t = 0; t < problem.targets.size(); ++t) {
    points.push_back(points_on_surface(problem.targets[t], state.shapes[t]));
  }
  return points;
}

}  // namespace

Rigid3 camera_from_target(const CalibrationProblem& problem, const BundleState& state, int view) {
  return state.camera_from_rig[problem.views[view].camera] * state.poses[state.pose_of_view[view]].rig_from_target;
}

std::vector<Eigen::Vector2d> view_residuals(const CalibrationProblem& problem, const BundleState& state, int view) {
  const TargetView& seen = problem.views[view];
  const auto points = points_on_surface(problem.targets[seen.target], state.shapes[seen.target]);
  return residuals_of(seen, projected_corners(problem, state, view, points));
}

std::vector<std::vector<Eigen::Vector2d>> all_residuals(const CalibrationProblem& problem, const BundleState& state) {
  const auto points = surfaces(problem, state);
  std::vector<std::vector<Eigen::Vector2d>> residuals;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const TargetView& view = problem.views[v];
    residuals.push_back(residuals_of(view, projected_corners(problem, state, v, points[view.target])));
  }
  return residuals;
}

void mark_projectable(const CalibrationProblem& problem, BundleState& state) {
  const auto points = surfaces(problem, state);
  state.fates.resize(problem.views.size());
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    std::vector<ObservationFate>& fates = state.fates[v];
    fates.resize(problem.views[v].observations.size(), ObservationFate::kUsed);
    const Eigen::MatrixX2d pixels = projected_corners(problem, state, v, points[problem.views[v].target]);
    for (std::size_t i = 0; i < fates.size(); ++i) {
      if (fates[i] == ObservationFate::kOutlier) continue;
      if (state.pose_of_view[v] < 0) {
        fates[i] = ObservationFate::kViewSetAside;
      } else {
        const bool projects = pixels.row(static_cast<Eigen::Index>(i)).allFinite();
        fates[i] = projects ? ObservationFate::kUsed : ObservationFate::kUnprojectable;
      }
    }
  }
}

}  // namespace raybundle
