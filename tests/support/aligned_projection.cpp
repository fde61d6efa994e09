// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "aligned_projection.hpp"

#include <Eigen/Cholesky>

namespace raybundle::testing {
namespace {

using Motion = Eigen::Matrix<double, 6, 1>;

Rigid3 moved(const Motion& motion) { return perturbed(Rigid3{}, motion); }

}  // namespace

std::vector<TrueCorner> true_corners(const SyntheticWorld& world, int camera) {
  std::vector<TrueCorner> corners;
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    const TargetView& view = world.problem.views[v];
    if (view.camera != camera) continue;
    const Target& target = world.problem.targets[view.target];
    const std::vector<Eigen::Vector3d> points = points_on_surface(target, world.shapes[view.target]);
    const Rigid3 camera_from_target =
        world.camera_from_rig[camera] * world.poses[world.pose_of_view[v]].rig_from_target;
    for (const Observation& observation : view.observations) {
      const Eigen::Vector3d x = camera_from_target * points[target.find(observation.point_id) - target.points.data()];
      corners.push_back({x, *pixel_from_ray(world.cameras[camera], x)});
    }
  }
  return corners;
}

Rigid3 aligning_motion(const std::vector<TrueCorner>& corners, const Camera& camera) {
  constexpr int kIterations = 4;  // it converges quadratically from a start that is off by noise
  constexpr double kStep = 1e-6;
  Motion motion = Motion::Zero();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Motion gradient = Motion::Zero();
    const Rigid3 here = moved(motion);
    for (const TrueCorner& corner : corners) {
      const Eigen::Vector3d x = here * corner.x_in_camera;
      const auto pixel = pixel_from_ray(camera, x);
      if (!pixel) continue;
      Eigen::Matrix<double, 2, 3> by_point;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
        by_point.col(axis) = (*pixel_from_ray(camera, x + step) - *pixel_from_ray(camera, x - step)) / (2.0 * kStep);
      }
      Eigen::Matrix<double, 2, 6> by_motion;
      for (int axis = 0; axis < 3; ++axis) {
        by_motion.col(axis) = by_point * Eigen::Vector3d::Unit(axis).cross(here.rotation * corner.x_in_camera);
      }
      by_motion.rightCols<3>() = by_point;
      normal += by_motion.transpose() * by_motion;
      gradient += by_motion.transpose() * (*pixel - corner.pixel);
    }
    const Rigid3 next = perturbed(here, -normal.ldlt().solve(gradient));
    motion = motion_between(Rigid3{}, next);
  }
  return moved(motion);
}

std::optional<Eigen::Vector2d> aligned_projection(const Camera& camera, const Rigid3& motion,
                                                  const Eigen::Vector3d& ray, double range_m) {
  return pixel_from_ray(camera, motion.rotation * ray + motion.translation / range_m);
}

}  // namespace raybundle::testing
