// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/tie_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "raybundle/geometry/threads.hpp"
#include "view_pose.hpp"

namespace raybundle {
namespace {

constexpr double kNear_px = 3.0;   ///< a corner fits its view's own pose within this
constexpr int kFewestCorners = 8;  ///< of a board's views

/// Squared distances of one view's right corners, tied and with a pose of its own.
struct ViewFit {
  double tied_px2 = 0.0;
  double own_px2 = 0.0;
  int corners = 0;
  Rigid3 own;
};

ViewFit fit_of(const PointsInView& corners, const Camera& camera, const Rigid3& tied) {
  const LensFunctions lens = lens_functions(camera.model);
  std::vector<double> tied_distances;
  pixel_distances(lens, camera.parameters.data(), corners, tied, tied_distances);
  std::vector<double> sorted = tied_distances;
  double typical_px = median(sorted);
  std::vector<Rigid3> own{tied};
  if (!(typical_px <= kNear_px)) {  // no refinement leads from so far away to where the board is
    if (const auto pose = view_pose(lens, camera.parameters.data(), corners, kNear_px)) {
      own[0] = pose->camera_from_target;
      typical_px = pose->median_px;
    }
  }
  LensBundleOptions options;
  options.scale_px = std::max(1e-3, 4.0 * typical_px);
  options.max_iterations = 15;
  options.lens_fixed = true;
  LensVector parameters = camera.parameters;
  if (std::isfinite(options.scale_px)) refine_lens(lens, {corners}, options, parameters, own);
  std::vector<double> own_distances;
  pixel_distances(lens, camera.parameters.data(), corners, own[0], own_distances);
  sorted = own_distances;
  const double right_px = 4.0 * median(sorted);  // corners that not even a pose of its own explains do not vote

  ViewFit fit;
  fit.own = own[0];
  for (std::size_t i = 0; i < own_distances.size(); ++i) {
    if (!(own_distances[i] <= right_px) || !std::isfinite(tied_distances[i])) continue;
    fit.tied_px2 += tied_distances[i] * tied_distances[i];
    fit.own_px2 += own_distances[i] * own_distances[i];
    ++fit.corners;
  }
  return fit;
}

// With points where the shape has them.
std::vector<Target> bent(std::vector<Target> boards, const std::vector<BoardShape>& shapes) {
  for (std::size_t t = 0; t < boards.size(); ++t) {
    const std::vector<Eigen::Vector3d> points = points_on_surface(boards[t], shapes[t]);
    for (std::size_t i = 0; i < points.size(); ++i) boards[t].points[i].x_in_target = points[i];
  }
  return boards;
}

/// How the views of one board in one frame fit.
struct FrameFit {
  TieCheck check;
  double lost_px2 = 0.0;      ///< by the tie, per degree of freedom
  double variance_px2 = 0.0;  ///< of corners around the views' own poses
};

// Joins the fits of a board's views; nothing where they have too few corners.
std::optional<FrameFit> joined(const CalibrationProblem& problem, int pose, const std::vector<int>& views,
                               const std::vector<ViewFit>& fits) {
  ViewFit all;
  std::string names;
  std::vector<Rigid3> own;
  for (std::size_t i = 0; i < views.size(); ++i) {
    all.tied_px2 += fits[i].tied_px2;
    all.own_px2 += fits[i].own_px2;
    all.corners += fits[i].corners;
    own.push_back(fits[i].own);
    const std::string& name = problem.cameras[problem.views[views[i]].camera].name;
    names += (i == 0 ? "" : i + 1 == views.size() ? " and " : ", ") + name;
  }
  if (all.corners < kFewestCorners) return std::nullopt;
  TieCheck check{pose, views, own, std::sqrt(all.tied_px2 / all.corners), std::sqrt(all.own_px2 / all.corners),
                 0.0,  {}};
  check.reason =
      fmt::format("{} fit to {:.2f} px together but to {:.2f} px apart", names, check.tied_rms_px, check.own_rms_px);
  const auto count = static_cast<double>(views.size());
  const double freedom = 2.0 * all.corners - 6.0 * count;
  return FrameFit{std::move(check), std::max(0.0, all.tied_px2 - all.own_px2) / (6.0 * (count - 1.0)),
                  all.own_px2 / std::max(1.0, freedom)};
}

}  // namespace

std::vector<TieCheck> check_ties(const CalibrationProblem& problem, const std::vector<Camera>& cameras,
                                 const std::vector<Rigid3>& camera_from_rig, const std::vector<BoardShape>& shapes,
                                 const std::vector<BoardPose>& poses, const std::vector<int>& pose_of_view,
                                 int threads) {
  const std::vector<Target> boards = bent(problem.targets, shapes);
  std::map<int, std::vector<int>> views_of_pose;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (pose_of_view[v] >= 0) views_of_pose[pose_of_view[v]].push_back(static_cast<int>(v));
  }
  std::erase_if(views_of_pose, [](const auto& shared) { return shared.second.size() < 2; });
  const std::vector<std::pair<int, std::vector<int>>> shared(views_of_pose.begin(), views_of_pose.end());
  std::vector<std::optional<FrameFit>> frames(shared.size());
  for_each_index(shared.size(), threads, [&](std::size_t f) {
    const auto& [pose, views] = shared[f];
    std::vector<ViewFit> fits;
    for (const int v : views) {
      const TargetView& view = problem.views[v];
      const Rigid3 tied = camera_from_rig[view.camera] * poses[pose].rig_from_target;
      fits.push_back(fit_of(points_in_view(boards[view.target], view), cameras[view.camera], tied));
    }
    frames[f] = joined(problem, pose, views, fits);
  });
  std::erase(frames, std::nullopt);
  std::vector<double> variances_px2;
  for (const auto& frame : frames) variances_px2.push_back(frame->variance_px2);
  const double variance_px2 = std::max(median(variances_px2), 1e-8);
  std::vector<TieCheck> checks;
  for (auto& frame : frames) {
    frame->check.excess = std::sqrt(frame->lost_px2 / variance_px2);
    checks.push_back(std::move(frame->check));
  }
  return checks;
}

}  // namespace raybundle
