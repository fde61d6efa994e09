// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "linear_pose.hpp"
#include "pose_refinement.hpp"
#include "raybundle/initialize/target_pose.hpp"
#include "view_screen.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kPlainCorners = 20;   ///< of a view, for the pose that is tried first
constexpr std::size_t kJudgedCorners = 36;  ///< of a view, for whether that one is right

constexpr double kSettled = 1e-2;  ///< of the cost: the bundle does the rest

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
  return angles.empty() ? 1.0 / parameters[0] : median(angles);
}

/// Rays of a view's corners where there are any, with the points they belong to.
struct RaysOfView {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> rays;
  double pixel_rad = 0.0;  ///< angle of one pixel, as the spread of the rays over that of the pixels
};

RaysOfView rays_of(const LensFunctions& lens, const double* parameters, const PointsInView& view) {
  RaysOfView seen;
  seen.points = view.points;
  seen.rays.resize(view.points.size());
  lens.unproject_all(parameters, view.pixels, seen.rays.data());
  double ray_steps = 0.0, pixel_steps = 0.0;
  std::size_t count = 0;
  Eigen::Vector2d last_pixel = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const Eigen::Vector3d ray = seen.rays[i];
    if (ray.isZero(0.0)) continue;
    if (count > 0) {
      ray_steps += (ray - seen.rays[count - 1]).norm();
      pixel_steps += (view.pixels[i] - last_pixel).norm();
    }
    last_pixel = view.pixels[i];
    seen.points[count] = view.points[i];
    seen.rays[count] = ray;
    ++count;
  }
  seen.points.resize(count);
  seen.rays.resize(count);
  seen.pixel_rad = pixel_steps > 0 ? ray_steps / pixel_steps : 0.0;
  return seen;
}

ViewPose judged(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                double threshold_px) {
  ViewPose result;
  result.camera_from_target = pose;
  pixel_distances(lens, parameters, view, pose, result.distances_px);
  judge(result, threshold_px);
  std::vector<double> sorted = result.distances_px;
  result.median_px = median(sorted);
  return result;
}

/// Whether of a view the corners that fit lie on one line of the board, about which it may turn freely.
bool fit_on_one_line(const PointsInView& view, const ViewPose& pose, double threshold_px) {
  if (pose.fitting == static_cast<int>(view.points.size())) return false;  // and all do not
  std::vector<Eigen::Vector3d> fitting;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    if (pose.distances_px[i] < threshold_px) fitting.push_back(view.points[i]);
  }
  return principal_frame(fitting).collinear();
}

/// Linear pose of the corners, refined with little weight for those that are far off, and the better one of the two
/// candidates that a flat board has.
std::optional<Rigid3> plain_pose(const LensFunctions& lens, const double* parameters, const PointsInView& view,
                                 double threshold_px) {
  const RaysOfView seen = rays_of(lens, parameters, view);
  const double scale_rad = threshold_px * seen.pixel_rad;
  if (seen.points.size() < 6 || !(scale_rad > 0)) return std::nullopt;
  const PrincipalFrame frame = principal_frame(seen.points);
  if (frame.collinear()) return std::nullopt;
  const bool flat = frame.spread[2] < 0.1 * frame.spread[0];
  const auto linear =
      flat ? linear_planar_pose(seen.points, seen.rays, frame) : linear_spatial_pose(seen.points, seen.rays, frame);
  if (!linear) return std::nullopt;
  Rigid3 pose = *linear;
  const auto refine = [&](Rigid3& some, int iterations) {
    return refine_on_rays(seen.points, seen.rays, some, iterations, scale_rad, kSettled);
  };
  const double cost = refine(pose, 10);
  if (!flat) return pose;
  Rigid3 mirrored = mirrored_pose(pose, frame);
  // Where perspective tells them apart, the first step shows it.
  if (refine(mirrored, 1) > 16.0 * cost || refine(mirrored, 1) > 4.0 * cost) return pose;
  return refine(mirrored, 10) < cost ? mirrored : pose;
}

}  // namespace

PointsInView points_in_view(const Target& target, const TargetView& view) {
  PointsInView result;
  result.points.resize(view.observations.size());
  result.pixels.resize(view.observations.size());
  std::size_t count = 0;
  for (const Observation& observation : view.observations) {
    const TargetPoint* point = target.find(observation.point_id);
    if (!point) continue;
    result.points[count] = point->x_in_target;
    result.pixels[count] = observation.pixel;
    ++count;
  }
  result.points.resize(count);
  result.pixels.resize(count);
  return result;
}

void judge(ViewPose& pose, double threshold_px) {
  pose.fitting = static_cast<int>(
      std::ranges::count_if(pose.distances_px, [&](double distance) { return distance < threshold_px; }));
}

std::optional<ViewPose> ransac_view_pose(const LensFunctions& lens, const double* parameters, const PointsInView& view,
                                         double threshold_px) {
  const RaysOfView seen = rays_of(lens, parameters, view);
  const double pixel_rad = angle_of_pixel(lens, parameters, view);
  // A wider gate on rays: a pixel's angle varies over the view, and the pixels decide in the end.
  const auto found = robust_target_pose(seen.points, seen.rays, std::min(2.0 * threshold_px * pixel_rad, 0.5));
  if (!found) return std::nullopt;

  std::vector<Rigid3> poses{found->camera_from_target};
  LensBundleOptions options;
  options.scale_px = threshold_px;
  options.max_iterations = 10;
  options.lens_fixed = true;
  LensVector fixed = Eigen::Map<const Eigen::VectorXd>(parameters, lens.parameters);
  refine_lens(lens, {view}, options, fixed, poses);
  return judged(lens, parameters, view, poses[0], threshold_px);
}

std::optional<ViewPose> view_pose(const LensFunctions& lens, const double* parameters, const PointsInView& view,
                                  double threshold_px) {
  const PointsInView some = thinned(view, kJudgedCorners);
  if (const auto quick = plain_pose(lens, parameters, thinned(some, kPlainCorners), threshold_px)) {
    ViewPose pose = judged(lens, parameters, some, *quick, threshold_px);
    const bool plainly_right = pose.median_px < 0.3 * threshold_px &&
                               static_cast<double>(pose.fitting) >= 0.75 * static_cast<double>(some.points.size()) &&
                               !fit_on_one_line(some, pose, threshold_px);
    if (plainly_right) return pose;
  }
  return ransac_view_pose(lens, parameters, view, threshold_px);
}

std::string reason_against(const std::optional<ViewPose>& pose, const PointsInView& view, double threshold_px) {
  if (pose && pose->fits()) return {};
  const std::size_t corners = view.points.size();
  if (corners < 4) return fmt::format("only {} corners were seen; a pose needs four", corners);
  if (principal_frame(view.points).collinear()) return fmt::format("its {} corners lie on one line", corners);
  std::string reason =
      fmt::format("only {} of {} corners fit within {:.1f} px", pose ? pose->fitting : 0, corners, threshold_px);
  if (pose && std::isfinite(pose->median_px)) reason += fmt::format(" (median {:.1f} px)", pose->median_px);
  return reason;
}

}  // namespace raybundle
