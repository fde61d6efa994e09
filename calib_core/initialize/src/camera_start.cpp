// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/camera_start.hpp"

#include <algorithm>
#include <cmath>

#include "lens_search.hpp"
#include "linear_pose.hpp"
#include "model_fit.hpp"
#include "parallel_boards.hpp"
#include "raybundle/geometry/error.hpp"
#include "start_lens.hpp"
#include "view_pose.hpp"
#include "view_screen.hpp"

namespace raybundle {
namespace {

constexpr double kFitPx = 3.0;              ///< a corner fits a good lens within this
constexpr std::size_t kSearchViews = 16;    ///< for the sweep
constexpr std::size_t kSearchCorners = 30;  ///< of each of them
constexpr std::size_t kRefineViews = 40;    ///< for the last refinement
constexpr std::size_t kRefineCorners = 60;
constexpr double kMaxFocalUncertainty = 0.2;  ///< relative; what is left to chance beyond this is not a start

/// The views of a camera with their corners.
struct CameraViews {
  std::vector<int> index;  ///< into problem.views
  std::vector<PointsInView> corners;
};

CameraViews views_of(const CalibrationProblem& problem, int camera) {
  CameraViews views;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera != camera) continue;
    views.index.push_back(static_cast<int>(v));
    views.corners.push_back(points_in_view(problem.targets[problem.views[v].target], problem.views[v]));
  }
  return views;
}

bool usable(const PointsInView& view) { return view.points.size() >= 4 && !principal_frame(view.points).collinear(); }

/// Rays of the corners that the start lens explains, and where it puts them.
PointsInView covered_field(const std::vector<PointsInView>& views, const LensGuess& guess) {
  const LensFunctions lens = lens_functions<StartLens>();
  PointsInView samples;
  std::vector<double> distances;
  for (std::size_t v = 0; v < views.size(); ++v) {
    pixel_distances(lens, guess.parameters.data(), views[v], guess.poses[v], distances);
    for (std::size_t i = 0; i < distances.size(); ++i) {
      if (!(distances[i] < 4.0 * guess.score_px + 1.0)) continue;
      const Eigen::Vector3d ray = (guess.poses[v] * views[v].points[i]).normalized();
      Eigen::Vector2d pixel;
      if (!lens.project(guess.parameters.data(), ray, pixel)) continue;
      samples.points.push_back(ray);
      samples.pixels.push_back(pixel);
    }
  }
  return samples;
}

/// Model parameters and poses together, on views that fit; what the conversion from the start lens lost is won back.
void polish(ModelId model, const std::vector<PointsInView>& views, LensGuess& guess) {
  const LensFunctions lens = lens_functions(model);
  for (int round = 0; round < 3; ++round) {
    LensBundleOptions options = model_options(model, guess.parameters, std::max(1.5, 4.0 * guess.score_px));
    options.max_iterations = 10;
    refine_lens(lens, views, options, guess.parameters, guess.poses);
    guess.score_px = robust_score(lens, guess.parameters.data(), views, guess.poses);
  }
}

std::vector<PointsInView> selection(const std::vector<PointsInView>& views, std::size_t count, std::size_t corners) {
  std::vector<PointsInView> selected;
  for (const std::size_t v : spread_views(views, count)) selected.push_back(thinned(views[v], corners));
  return selected;
}

/// Poses of all views under a lens: RANSAC at a threshold for each, infinite score where there is none.
std::vector<std::optional<ViewPose>> all_poses(const LensFunctions& lens, const LensVector& parameters,
                                               const std::vector<PointsInView>& views, double threshold_px) {
  std::vector<std::optional<ViewPose>> poses;
  for (const PointsInView& view : views) {
    poses.push_back(usable(view) ? view_pose(lens, parameters.data(), view, threshold_px) : std::nullopt);
  }
  return poses;
}

/// A corner fits within this [px]: 3 px, or more for a model that leaves large residuals everywhere.
double fit_threshold(const std::vector<std::optional<ViewPose>>& poses) {
  std::vector<double> medians;
  for (const auto& pose : poses) {
    if (pose && std::isfinite(pose->median_px)) medians.push_back(pose->median_px);
  }
  return medians.empty() ? kFitPx : std::clamp(5.0 * quantile(medians, 0.5), kFitPx, 50.0);
}

/// The lens from the views alone, in the model asked for.
LensVector find_lens(const ProblemCamera& camera, const std::vector<PointsInView>& all) {
  std::vector<PointsInView> views;
  for (const PointsInView& view : all) {
    if (usable(view)) views.push_back(view);
  }
  if (views.size() < 3) {
    throw Error(ErrorKind::kNotEnoughData,
                "only " + std::to_string(views.size()) + " of " + std::to_string(all.size()) +
                    " views show four corners or more, and a lens needs three; take more images of the board",
                "camera " + camera.name);
  }
  std::vector<PointsInView> chosen;
  for (const std::size_t v : spread_views(views, kSearchViews)) {
    chosen.push_back(thinned(screened(views[v]), kSearchCorners));
  }
  const LensGuess start = search_lens(chosen, camera.size).front();
  const double uncertainty = focal_uncertainty(chosen, camera.size, start);
  if (!(uncertainty < kMaxFocalUncertainty)) {
    throw Error(
        ErrorKind::kNotEnoughData,
        "the views leave the focal length open (to about " +
            std::to_string(static_cast<int>(std::min(100 * uncertainty, 999.0))) +
            " %), as boards do that are all parallel to the image; tilt the board by 20 to 45 degrees in some images",
        "camera " + camera.name);
  }
  if (all_parallel_to_image(chosen, start.score_px)) {
    throw Error(ErrorKind::kNotEnoughData,
                "the board is parallel to the image in all views, so that focal length and distance cannot be told "
                "apart; tilt the board by 20 to 45 degrees in some images",
                "camera " + camera.name);
  }
  LensGuess guess;
  guess.parameters = fit_model(camera.model, covered_field(chosen, start), start.parameters);
  const LensFunctions lens = lens_functions(camera.model);
  guess.poses = start.poses;
  guess.score_px = robust_score(lens, guess.parameters.data(), chosen, guess.poses);
  polish(camera.model, chosen, guess);

  // Once more with more views, those that fit.
  std::vector<PointsInView> more = selection(views, kRefineViews, kRefineCorners);
  const double threshold = std::clamp(5.0 * guess.score_px, kFitPx, 50.0);
  LensGuess last;
  last.parameters = guess.parameters;
  std::vector<PointsInView> fitting;
  for (const PointsInView& view : more) {
    const auto pose = view_pose(lens, guess.parameters.data(), view, threshold);
    if (!reason_against(pose, view, threshold).empty()) continue;
    fitting.push_back(view);
    last.poses.push_back(pose->camera_from_target);
  }
  if (fitting.size() < 3) return guess.parameters;
  last.score_px = robust_score(lens, last.parameters.data(), fitting, last.poses);
  polish(camera.model, fitting, last);
  return last.parameters;
}

}  // namespace

CameraStart initialize_camera(const CalibrationProblem& problem, int camera) {
  const ProblemCamera& wanted = problem.cameras[camera];
  const CameraViews views = views_of(problem, camera);
  const LensFunctions lens = lens_functions(wanted.model);
  const LensVector parameters = wanted.parameters ? LensVector(*wanted.parameters) : find_lens(wanted, views.corners);

  std::vector<std::optional<ViewPose>> poses = all_poses(lens, parameters, views.corners, 2 * kFitPx);
  const double threshold = fit_threshold(poses);
  if (threshold != 2 * kFitPx) poses = all_poses(lens, parameters, views.corners, threshold);

  CameraStart start;
  start.camera = {wanted.model, wanted.size, parameters};
  start.camera_from_target.resize(problem.views.size());
  start.reasons.resize(problem.views.size());
  for (std::size_t i = 0; i < views.index.size(); ++i) {
    const int v = views.index[i];
    start.reasons[v] = reason_against(poses[i], views.corners[i], threshold);
    if (start.reasons[v].empty()) start.camera_from_target[v] = poses[i]->camera_from_target;
  }
  return start;
}

std::optional<Rigid3> initialize_view(const CalibrationProblem& problem, const TargetView& view, const Camera& camera,
                                      std::string& reason) {
  const PointsInView corners = points_in_view(problem.targets[view.target], view);
  const LensFunctions lens = lens_functions(camera.model);
  std::optional<ViewPose> pose;
  if (usable(corners)) pose = view_pose(lens, camera.parameters.data(), corners, kFitPx);
  reason = reason_against(pose, corners, kFitPx);
  if (!reason.empty()) return std::nullopt;
  return pose->camera_from_target;
}

}  // namespace raybundle
