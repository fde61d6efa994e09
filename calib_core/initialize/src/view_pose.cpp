// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_pose.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "linear_pose.hpp"
#include "raybundle/initialize/target_pose.hpp"

namespace raybundle {
namespace {

/// Angle [rad] of one pixel where the view's corners are: the median over some of them.
double angle_of_pixel(const LensFunctions& lens, const double* parameters, const PointsInView& view) {
  std::vector<double> angles;
  const std::size_t stride = std::max<std::size_t>(1, view.pixels.size() / 8);
  for (std::size_t i = 0; i < view.pixels.size(); i += stride) {
    for (const Eigen::Vector2d& step : {Eigen::Vector2d(0.5, 0), Eigen::Vector2d(0, 0.5)}) {
      Eigen::Vector3d a;
      Eigen::Vector3d b;
      if (!lens.unproject(parameters, view.pixels[i] - step, a)) continue;
      if (!lens.unproject(parameters, view.pixels[i] + step, b)) continue;
      angles.push_back((a.normalized() - b.normalized()).norm());
    }
  }
  return angles.empty() ? 1.0 / parameters[0] : quantile(angles, 0.5);
}

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

}  // namespace

PointsInView points_in_view(const Target& target, const TargetView& view) {
  PointsInView result;
  result.points.reserve(view.observations.size());
  result.pixels.reserve(view.observations.size());
  for (const Observation& observation : view.observations) {
    const TargetPoint* point = target.find(observation.point_id);
    if (!point) continue;
    result.points.push_back(point->x_in_target);
    result.pixels.push_back(observation.pixel);
  }
  return result;
}

std::optional<ViewPose> view_pose(const LensFunctions& lens, const double* parameters, const PointsInView& view,
                                  double threshold_px) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> rays;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    Eigen::Vector3d ray;
    if (!lens.unproject(parameters, view.pixels[i], ray)) continue;
    points.push_back(view.points[i]);
    rays.push_back(ray.normalized());
  }
  const double pixel_rad = angle_of_pixel(lens, parameters, view);
  // A wider gate on rays: a pixel's angle varies over the view, and the pixels decide in the end.
  const auto found = robust_target_pose(points, rays, std::min(2.0 * threshold_px * pixel_rad, 0.5));
  if (!found) return std::nullopt;

  std::vector<Rigid3> poses{found->camera_from_target};
  LensBundleOptions options;
  options.scale_px = threshold_px;
  options.max_iterations = 10;
  options.lens_fixed = true;
  LensVector fixed = Eigen::Map<const Eigen::VectorXd>(parameters, lens.parameters);
  refine_lens(lens, {view}, options, fixed, poses);

  ViewPose result;
  result.camera_from_target = poses[0];
  std::vector<double> distances;
  pixel_distances(lens, parameters, view, poses[0], distances);
  result.fitting =
      static_cast<int>(std::ranges::count_if(distances, [&](double distance) { return distance < threshold_px; }));
  result.median_px = quantile(distances, 0.5);
  return result;
}

int corners_needed(std::size_t corners) { return std::max(4, static_cast<int>((corners + 1) / 2)); }

std::string reason_against(const std::optional<ViewPose>& pose, const PointsInView& view, double threshold_px) {
  const std::string corners = std::to_string(view.points.size());
  if (view.points.size() < 4) return "only " + corners + " corners were seen; a pose needs four";
  if (principal_frame(view.points).collinear()) return "its " + corners + " corners lie on one line";
  const int fitting = pose ? pose->fitting : 0;
  if (fitting >= corners_needed(view.points.size())) return {};
  std::string reason =
      "only " + std::to_string(fitting) + " of " + corners + " corners fit within " + text("%.1f px", threshold_px);
  if (pose && std::isfinite(pose->median_px)) reason += " (median " + text("%.1f px", pose->median_px) + ")";
  return reason;
}

}  // namespace raybundle
