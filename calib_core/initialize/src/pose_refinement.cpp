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

constexpr double kNoDecrease = 1e-13;  ///< of the cost: rounding

/// Normal equations of a pose's rotation and translation.
struct PoseEquations {
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
};

/// Cost of a pose, and its equations when asked for.
double chord_cost(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> rays, const Rigid3& pose,
                  double scale, PoseEquations* equations = nullptr) {
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
    if (!equations) continue;
    // With a = I - d dᵀ: [arm]× a = [arm]× - (arm × d) dᵀ, and [arm]× a [arm]×ᵀ = |arm|² I - arm armᵀ - (arm × d)(arm ×
    // d)ᵀ.
    const double weight = damping * damping / distance, weight2 = weight / distance;
    const Eigen::Vector3d across = arm.cross(direction);
    Matrix6& hessian = equations->hessian;
    const Eigen::Vector3d arm_of_weight = weight2 * arm, across_of_weight = weight2 * across;
    const Eigen::Vector3d direction_of_weight = weight2 * direction;
    hessian.topLeftCorner<3, 3>() -= arm_of_weight * arm.transpose() + across_of_weight * across.transpose();
    hessian.diagonal().head<3>().array() += arm_of_weight.dot(arm);
    hessian.topRightCorner<3, 3>() += skew(arm_of_weight) - across_of_weight * direction.transpose();
    hessian.bottomRightCorner<3, 3>() -= direction_of_weight * direction.transpose();
    hessian.diagonal().tail<3>().array() += weight2;
    const Eigen::Vector3d b = weight * (chord - direction * direction.dot(chord));
    equations->gradient.head<3>() += arm.cross(b);
    equations->gradient.tail<3>() += b;
  }
  if (equations) {
    equations->hessian.bottomLeftCorner<3, 3>() = equations->hessian.topRightCorner<3, 3>().transpose();
  }
  return cost;
}

}  // namespace

double refine_on_rays(std::span<const Eigen::Vector3d> points_in_target,
                      std::span<const Eigen::Vector3d> rays_in_camera, Rigid3& pose, int max_iterations,
                      double scale_rad, double settled) {
  double lambda = 1e-6;
  PoseEquations equations;
  double cost = chord_cost(points_in_target, rays_in_camera, pose, scale_rad, &equations);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    bool improved = false;
    bool converged = false;
    while (!improved && lambda < 1e8) {
      Matrix6 damped = equations.hessian;
      damped.diagonal() *= 1.0 + lambda;
      const Vector6 step = damped.ldlt().solve(-equations.gradient);
      const double decrease = -equations.gradient.dot(step);  // that the equations promise
      if (!(std::abs(decrease) > kNoDecrease * cost)) break;
      const Rigid3 moved = perturbed(pose, step);
      const bool last = iteration + 1 == max_iterations || std::abs(decrease) < settled * cost;
      PoseEquations moved_equations;
      const double moved_cost =
          chord_cost(points_in_target, rays_in_camera, moved, scale_rad, last ? nullptr : &moved_equations);
      if (moved_cost < cost) {
        converged = last || cost - moved_cost < settled * cost;
        pose = moved;
        cost = moved_cost;
        equations = moved_equations;
        lambda = std::max(lambda * 0.1, 1e-12);
        improved = true;
      } else {
        lambda *= lambda < 1e-3 ? 100.0 : 10.0;
      }
    }
    if (!improved || converged) break;
  }
  return cost;
}

}  // namespace raybundle
