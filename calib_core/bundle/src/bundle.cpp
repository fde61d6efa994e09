// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/bundle.hpp"

#include <limits>

namespace raybundle {
namespace {

// Pixel of each observation of a view; NaN where the model does not project it.
std::vector<Eigen::Vector2d> projected(const CalibrationProblem& problem, const BundleState& state, int view) {
  const TargetView& seen = problem.views[view];
  const Target& target = problem.targets[seen.target];
  const Camera& camera = state.cameras[seen.camera];
  const std::vector<Eigen::Vector3d> points = points_on_surface(target, state.shapes[seen.target]);
  std::vector<Eigen::Vector2d> pixels(seen.observations.size(),
                                      Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  if (state.pose_of_view[view] < 0) return pixels;
  const Rigid3 pose = camera_from_target(problem, state, view);
  with_model(camera.model, [&]<CameraModel M>() {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const TargetPoint* point = target.find(seen.observations[i].point_id);
      const Eigen::Vector3d& x = points[point - target.points.data()];
      const Eigen::Vector3d ray = point->infinitely_far ? Eigen::Vector3d(pose.rotation * x) : pose * x;
      Eigen::Vector2d pixel;
      if (pixel_from_ray<M>(camera.parameters.data(), ray.data(), pixel.data())) pixels[i] = pixel;
    }
  });
  return pixels;
}

}  // namespace

Rigid3 camera_from_target(const CalibrationProblem& problem, const BundleState& state, int view) {
  return state.camera_from_rig[problem.views[view].camera] * state.poses[state.pose_of_view[view]].rig_from_target;
}

std::vector<Eigen::Vector2d> view_residuals(const CalibrationProblem& problem, const BundleState& state, int view) {
  std::vector<Eigen::Vector2d> residuals = projected(problem, state, view);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    residuals[i] = problem.views[view].observations[i].pixel - residuals[i];
  }
  return residuals;
}

void mark_projectable(const CalibrationProblem& problem, BundleState& state) {
  state.fates.resize(problem.views.size());
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    std::vector<ObservationFate>& fates = state.fates[v];
    fates.resize(problem.views[v].observations.size(), ObservationFate::kUsed);
    const std::vector<Eigen::Vector2d> pixels = projected(problem, state, v);
    for (std::size_t i = 0; i < fates.size(); ++i) {
      if (fates[i] == ObservationFate::kOutlier) continue;
      if (state.pose_of_view[v] < 0) {
        fates[i] = ObservationFate::kViewSetAside;
      } else {
        fates[i] = pixels[i].allFinite() ? ObservationFate::kUsed : ObservationFate::kUnprojectable;
      }
    }
  }
}

}  // namespace raybundle
