// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/scene/board_surface.hpp"

namespace raybundle {
namespace {

// Pixel of each dot of a view whose beam the state holds; NaN where there is no prediction.
std::vector<Eigen::Vector2d> predicted(const CalibrationProblem& problem, const BundleState& state, int view) {
  const TargetView& seen = problem.views[view];
  std::vector<Eigen::Vector2d> pixels(seen.dots.size(),
                                      Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  if (state.pose_of_view[view] < 0 || state.beams.empty() || seen.dots.empty()) return pixels;
  const BoardSurface surface(problem.targets[seen.target]);
  const Camera& camera = state.cameras[seen.camera];
  const Rigid3& camera_from_rig = state.camera_from_rig[seen.camera];
  const Rigid3& rig_from_target = state.poses[state.pose_of_view[view]].rig_from_target;
  const Rigid3 target_from_rig = rig_from_target.inverse();
  with_model(camera.model, [&]<CameraModel M>() {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const int beam = seen.dots[i].beam;
      if (beam == kUnlabelled || !state.beams[beam]) continue;
      const std::optional<Eigen::Vector3d> x =
          surface.crossing(target_from_rig * *state.beams[beam], state.shapes[seen.target]);
      if (!x) continue;
      const Eigen::Vector3d ray = camera_from_rig * (rig_from_target * *x);
      Eigen::Vector2d pixel;
      if (pixel_from_ray<M>(camera.parameters.data(), ray.data(), pixel.data())) pixels[i] = pixel;
    }
  });
  return pixels;
}

}  // namespace

std::vector<Eigen::Vector2d> dot_residuals(const CalibrationProblem& problem, const BundleState& state, int view) {
  std::vector<Eigen::Vector2d> residuals = predicted(problem, state, view);
  for (std::size_t i = 0; i < residuals.size(); ++i) residuals[i] = problem.views[view].dots[i].pixel - residuals[i];
  return residuals;
}

void mark_dots(const CalibrationProblem& problem, BundleState& state) {
  state.dot_fates.resize(problem.views.size());
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const std::vector<Dot>& dots = problem.views[v].dots;
    std::vector<ObservationFate>& fates = state.dot_fates[v];
    fates.resize(dots.size(), ObservationFate::kUsed);
    const std::vector<Eigen::Vector2d> pixels = predicted(problem, state, v);
    for (std::size_t i = 0; i < fates.size(); ++i) {
      if (fates[i] == ObservationFate::kOutlier) continue;
      if (state.pose_of_view[v] < 0) {
        fates[i] = ObservationFate::kViewSetAside;
      } else if (dots[i].beam == kUnlabelled) {
        fates[i] = ObservationFate::kUnlabelled;
      } else {
        fates[i] = pixels[i].allFinite() ? ObservationFate::kUsed : ObservationFate::kUnprojectable;
      }
    }
  }
}

}  // namespace raybundle
