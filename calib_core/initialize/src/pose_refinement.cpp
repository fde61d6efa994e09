// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "pose_refinement.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Cost of a pose, and the normal equations of its rotation and translation when asked for.
double chord_cost(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> rays, const Rigid3& pose,
                  double scale, Matrix6* hessian, Vector6* gradient) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  const double scale2 = scale * scale;
  double cost = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d arm = rotation * points[i];
    const Eigen::Vector3d x = arm + pose.translation;
    const double distance = x.norm();
    if (!(distance > 1e-12)) {  // a board point in the centre of projection has no direction
      cost += scale > 0 ? scale2 : 4.0;
      continue;
    }
    const Eigen::Vector3d direction = x / distance;
    const Eigen::Vector3d chord = direction - rays[i];
    const double chord2 = chord.squaredNorm();
    const double damping = scale > 0 ? scale2 / (scale2 + chord2) : 1.0;
    cost += chord2 * damping;
    if (!hessian) continue;
    const double weight = damping * damping;
    const Eigen::Matrix3d a =
        (Eigen::Matrix3d::Identity() - direction * direction.transpose()) * (weight / (distance * distance));
    const Eigen::Vector3d b = (chord - direction * direction.dot(chord)) * (weight / distance);
    const Eigen::Matrix3d cross = skew(arm);
    const Eigen::Matrix3d cross_a = cross * a;
    hessian->topLeftCorner<3, 3>() -= cross_a * cross;
    hessian->topRightCorner<3, 3>() += cross_a;
    hessian->bottomRightCorner<3, 3>() += a;
    gradient->head<3>() += arm.cross(b);
    gradient->tail<3>() += b;
  }
  return cost;
}

}  // namespace

double refine_on_rays(std::span<const Eigen::Vector3d> points_in_target,
                      std::span<const Eigen::Vector3d> rays_in_camera, Rigid3& pose, int max_iterations,
                      double scale_rad, double settled) {
  double lambda = 1e-6;
  double cost = chord_cost(points_in_target, rays_in_camera, pose, scale_rad, nullptr, nullptr);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    Matrix6 hessian = Matrix6::Zero();
    Vector6 gradient = Vector6::Zero();
    chord_cost(points_in_target, rays_in_camera, pose, scale_rad, &hessian, &gradient);
    hessian.bottomLeftCorner<3, 3>() = hessian.topRightCorner<3, 3>().transpose();
    bool improved = false;
    bool converged = false;
    while (!improved && lambda < 1e8) {
      Matrix6 damped = hessian;
      damped.diagonal() *= 1.0 + lambda;
      const Vector6 step = damped.ldlt().solve(-gradient);
      if (!step.allFinite()) break;
      const Rigid3 moved = perturbed(pose, step);
      const double moved_cost = chord_cost(points_in_target, rays_in_camera, moved, scale_rad, nullptr, nullptr);
      if (moved_cost < cost) {
        converged = cost - moved_cost < settled * cost;
        pose = moved;
        cost = moved_cost;
        lambda = std::max(lambda * 0.1, 1e-12);
        improved = true;
      } else {
        lambda *= lambda < 1e-3 ? 100.0 : 10.0;
      }
    }
    if (!improved || converged) break;
  }
  if (scale_rad > 0) cost = chord_cost(points_in_target, rays_in_camera, pose, 0.0, nullptr, nullptr);
  return std::sqrt(cost / static_cast<double>(std::max<std::size_t>(points_in_target.size(), 1)));
}

double cost_on_rays(std::span<const Eigen::Vector3d> points_in_target, std::span<const Eigen::Vector3d> rays_in_camera,
                    const Rigid3& pose, double scale_rad) {
  return chord_cost(points_in_target, rays_in_camera, pose, scale_rad, nullptr, nullptr);
}

}  // namespace raybundle
