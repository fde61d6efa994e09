// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "summary.hpp"

#include <cmath>

#include "raybundle/geometry/quantile.hpp"

namespace raybundle {
namespace {

// Poses that views in use refer to, renumbered; `new_index` maps the state's poses, -1 where unused.
std::vector<BoardPose> poses_in_use(const BundleState& state, std::vector<int>& new_index) {
  std::vector<bool> used(state.poses.size(), false);
  for (int pose : state.pose_of_view) {
    if (pose >= 0) used[pose] = true;
  }
  std::vector<BoardPose> poses;
  new_index.assign(state.poses.size(), -1);
  for (std::size_t p = 0; p < state.poses.size(); ++p) {
    if (!used[p]) continue;
    new_index[p] = static_cast<int>(poses.size());
    poses.push_back(state.poses[p]);
  }
  return poses;
}

ViewResult view_result(const CalibrationProblem& problem, const BundleState& state, int view,
                       const std::vector<Eigen::Vector2d>& residuals) {
  ViewResult result;
  result.fates = state.fates[view];
  const Eigen::Vector2d none = Eigen::Vector2d::Constant(std::nan(""));
  result.residuals_px.assign(problem.views[view].observations.size(), none);
  for (const Dot& dot : problem.views[view].dots) result.beam_of_dot.push_back(dot.beam);
  result.dot_fates.assign(result.beam_of_dot.size(), ObservationFate::kUnlabelled);
  result.dot_residuals_px.assign(result.beam_of_dot.size(), none);
  if (!state.beams.empty()) {
    result.dot_fates = state.dot_fates[view];
    result.dot_residuals_px = dot_residuals(problem, state, view);
  }
  if (state.pose_of_view[view] < 0) return result;
  result.residuals_px = residuals;
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < result.fates.size(); ++i) {
    if (result.fates[i] != ObservationFate::kUsed) continue;
    sum += result.residuals_px[i].squaredNorm();
    ++count;
  }
  result.rms_px = count > 0 ? std::sqrt(sum / count) : 0.0;
  return result;
}

}  // namespace

void fill_result(const CalibrationProblem& problem, const BundleState& state, CalibrationResult& result) {
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    result.calibration.cameras.push_back({problem.cameras[c].name, state.cameras[c], state.camera_from_rig[c]});
  }
  for (std::size_t t = 0; t < problem.targets.size(); ++t) {
    result.calibration.targets.push_back({problem.targets[t], state.shapes[t]});
  }
  std::vector<int> new_index;
  result.poses = poses_in_use(state, new_index);

  result.cameras.assign(problem.cameras.size(), {});
  const std::vector<std::vector<Eigen::Vector2d>> residuals = all_residuals(problem, state);
  std::vector<std::vector<double>> distances(problem.cameras.size());
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    ViewResult view = view_result(problem, state, v, residuals[v]);
    view.pose = state.pose_of_view[v] < 0 ? -1 : new_index[state.pose_of_view[v]];
    const int camera = problem.views[v].camera;
    CameraSummary& summary = result.cameras[camera];
    summary.views_total += 1;
    summary.views_used += view.pose >= 0;
    for (std::size_t i = 0; i < view.fates.size(); ++i) {
      summary.corners_outlier += view.fates[i] == ObservationFate::kOutlier;
      if (view.fates[i] == ObservationFate::kUsed) distances[camera].push_back(view.residuals_px[i].norm());
    }
    result.views.push_back(std::move(view));
  }

  double sum_of_all = 0.0;
  std::size_t count_of_all = 0;
  for (std::size_t c = 0; c < distances.size(); ++c) {
    std::vector<double>& of_camera = distances[c];
    if (of_camera.empty()) continue;
    double sum = 0.0;
    for (double distance : of_camera) sum += distance * distance;
    result.cameras[c].corners_used = static_cast<int>(of_camera.size());
    result.cameras[c].rms_px = std::sqrt(sum / static_cast<double>(of_camera.size()));
    result.cameras[c].median_px = median(of_camera);
    sum_of_all += sum;
    count_of_all += of_camera.size();
  }
  result.rms_px = count_of_all > 0 ? std::sqrt(sum_of_all / static_cast<double>(count_of_all)) : 0.0;
}

}  // namespace raybundle
