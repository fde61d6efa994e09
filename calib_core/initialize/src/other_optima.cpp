// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/other_optima.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lens_bundle.hpp"
#include "linear_pose.hpp"
#include "model_fit.hpp"
#include "view_screen.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kSamples = 80;  ///< rays that twins are compared on
constexpr double kFarTimes = 3.0;     ///< the linear prediction exceeds what is seen by this factor between twins ...
constexpr double kFar_px = 0.3;       ///< ... and this much

constexpr double kLargestRatio = 4.0;   ///< of the squared distances of a mirrored pose that may be meant
constexpr double kHopeless = 60.0;      ///< the same, before the pose has settled, ...
constexpr std::size_t kFirstLook = 24;  ///< ... of some corners
constexpr double kNoneWrong_px = 50.0;  ///< scale of the loss: the corners are right, only the pose may be far off
constexpr double kNarrow = 0.5;         ///< a board that spreads less across its length takes longer to settle
constexpr double kTurn_rad = 0.4;       ///< of a narrow board about its length
constexpr double kSame_rad = 1e-3;      ///< the way led back to the given pose

double sum_of_squares(const LensFunctions& lens, const LensVector& parameters, const PointsInView& view,
                      const Rigid3& pose) {
  std::vector<double> distances;
  pixel_distances(lens, parameters.data(), view, pose, distances);
  return std::accumulate(distances.begin(), distances.end(), 0.0, [](double sum, double d) { return sum + d * d; });
}

bool narrow(const PrincipalFrame& frame) { return frame.spread[1] < kNarrow * frame.spread[0]; }

// Where to look for the other pose of a board: mirrored at the plane across the line of sight. A narrow board shows so
// little of how it is turned about its length that the mirrored pose may lead back; it may be turned farther.
std::vector<Rigid3> other_poses(const Rigid3& camera_from_target, const PrincipalFrame& frame) {
  std::vector<Rigid3> poses{mirrored_pose(camera_from_target, frame)};
  if (!narrow(frame)) return poses;
  const Eigen::Vector3d length = frame.local_from_target.row(0).transpose(), centre = camera_from_target * frame.centre;
  for (const double turn_rad : {kTurn_rad, -kTurn_rad}) {
    const Eigen::AngleAxisd turn(turn_rad, length);
    const Eigen::Quaterniond rotation = (camera_from_target.rotation * turn).normalized();
    poses.push_back({rotation, centre - rotation * frame.centre});
  }
  return poses;
}

}  // namespace

std::vector<Camera> twin_cameras(const Camera& camera, const std::vector<Eigen::Vector3d>& rays_in_camera,
                                 double alike_px) {
  const LensFunctions lens = lens_functions(camera.model);
  const PointsInView field = field_seen(camera, rays_in_camera, kSamples);
  std::vector<Camera> twins;
  if (field.points.empty()) return twins;
  LensBundleOptions here;
  here.poses_fixed = true;
  here.max_iterations = 0;
  here.with_information = true;
  std::vector<Rigid3> identity(1);
  const auto information_at = [&](LensVector parameters) {
    return refine_lens(lens, {field}, here, parameters, identity).information;
  };
  const LensMatrix information = information_at(camera.parameters);
  for (const LensVector& other : model_fits(camera.model, field, camera.parameters)) {
    const auto count = static_cast<double>(field.points.size());
    const double seen_px = std::sqrt(sum_of_squares(lens, other, field, Rigid3{}) / count);
    const LensVector step = other - LensVector(camera.parameters);
    if (!(seen_px < alike_px)) continue;
    // From both ends: between twins lies a place, perhaps this one, where the step moves no pixel at first.
    const double predicted2 = std::max(step.dot(information * step), step.dot(information_at(other) * step));
    const double predicted_px = std::sqrt(std::max(0.0, predicted2) / count);
    if (predicted_px < kFar_px || predicted_px < kFarTimes * seen_px) continue;
    const bool known = std::ranges::any_of(twins, [&](const Camera& twin) {
      const LensVector apart = other - LensVector(twin.parameters);
      return apart.norm() < 0.1 * step.norm();
    });
    if (!known) twins.push_back({camera.model, camera.size, other});
  }
  return twins;
}

Camera fitted_anew(const Camera& camera, const std::vector<Eigen::Vector3d>& rays_in_camera,
                   const std::vector<Eigen::Vector2d>& pixels, const std::vector<int>& zeros) {
  return {camera.model, camera.size, fit_model(camera.model, {rays_in_camera, pixels}, camera.parameters, zeros)};
}

std::optional<MirroredPose> find_mirrored_pose(const Camera& camera, std::span<const Eigen::Vector3d> points_in_target,
                                               std::span<const Eigen::Vector2d> pixels,
                                               const Rigid3& camera_from_target) {
  const PrincipalFrame frame = principal_frame(points_in_target);
  if (points_in_target.size() < 4 || frame.collinear() || !frame.planar()) return std::nullopt;
  const LensFunctions lens = lens_functions(camera.model);
  const PointsInView view{{points_in_target.begin(), points_in_target.end()}, {pixels.begin(), pixels.end()}};
  const PointsInView some = thinned(view, kFirstLook);
  LensVector parameters = camera.parameters;
  const auto squares = [&](const PointsInView& corners, const Rigid3& pose) {
    return sum_of_squares(lens, parameters, corners, pose);
  };
  const double hopeless = kHopeless * squares(some, camera_from_target);
  LensBundleOptions options;
  options.lens_fixed = true;
  options.scale_px = kNoneWrong_px;
  const double squares_here = squares(view, camera_from_target);
  std::optional<MirroredPose> best;
  for (const Rigid3& start : other_poses(camera_from_target, frame)) {
    std::vector<Rigid3> pose{start};
    options.max_iterations = narrow(frame) ? 12 : 4;  // most boards fit one of the two only, and are soon known to
    refine_lens(lens, {some}, options, parameters, pose);
    if (!(squares(some, pose[0]) < hopeless)) continue;
    options.max_iterations = 20;
    refine_lens(lens, {view}, options, parameters, pose);
    if (pose[0].rotation.angularDistance(camera_from_target.rotation) < kSame_rad) continue;
    const double ratio = squares(view, pose[0]) / squares_here;
    if (ratio < (best ? best->squares_ratio : kLargestRatio)) best = {pose[0], ratio};
  }
  return best;
}

}  // namespace raybundle
