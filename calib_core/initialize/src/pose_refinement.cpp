// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "pose_refinement.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "raybundle/camera/lanes.hpp"
#include "raybundle/geometry/target_clones.hpp"
#include "small_cholesky.hpp"

namespace raybundle {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kNoDecrease = 1e-13;  ///< of the cost: rounding

/// Normal equations of a pose's rotation and translation.
struct PoseEquations {
  Matrix6 hessian = Matrix6::Zero();  ///< lower triangle
  Vector6 gradient = Vector6::Zero();
};

/// A pose and how far wrong rays pull.
struct ChordPoint {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  double scale;
};

/// Sums over the pairs, of one number or of lanes of them: upper triangles of the hessian, row by row.
template <typename Number>
struct ChordSums {
  Number cost{0.0};
  Number turn[6]{0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  Number turn_and_shift[9]{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  Number shift[6]{0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  Number gradient[6]{0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
};

template <typename Number>
[[gnu::always_inline]] inline void cross(const Number* a, const Number* b, Number* product) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

/// Adds a pair, or as many as there are lanes; false where a point lies in the centre of projection.
template <bool kWithEquations, typename Number>
[[gnu::always_inline]] inline bool add_pairs(const Eigen::Vector3d* points, const Eigen::Vector3d* rays,
                                             const ChordPoint& at, ChordSums<Number>& sums) {
  using std::sqrt;
  Number point[3], ray[3], arm[3], x[3];
  load(points, point);
  load(rays, ray);
  for (int r = 0; r < 3; ++r) {
    arm[r] = at.rotation(r, 0) * point[0] + at.rotation(r, 1) * point[1] + at.rotation(r, 2) * point[2];
    x[r] = arm[r] + Number(at.translation[r]);
  }
  const Number distance = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
  if (!(distance > Number(1e-12))) return false;
  const Number nearness = Number(1.0) / distance;
  Number direction[3], chord[3];
  for (int k = 0; k < 3; ++k) {
    direction[k] = x[k] * nearness;
    chord[k] = direction[k] - ray[k];
  }
  const Number chord2 = chord[0] * chord[0] + chord[1] * chord[1] + chord[2] * chord[2];
  const double scale2 = at.scale * at.scale;
  const Number damping = at.scale > 0 ? scale2 / (scale2 + chord2) : Number(1.0);
  sums.cost += chord2 * damping;
  if constexpr (kWithEquations) {
    // With a = I - d dᵀ: [arm]× a = [arm]× - (arm × d) dᵀ, and
    // [arm]× a [arm]×ᵀ = |arm|² I - arm armᵀ - (arm × d)(arm × d)ᵀ.
    const Number weight = damping * damping * nearness, weight2 = weight * nearness;
    Number across[3], weighted_arm[3];
    cross(arm, direction, across);
    for (int k = 0; k < 3; ++k) weighted_arm[k] = weight2 * arm[k];
    const Number arm2 = weighted_arm[0] * arm[0] + weighted_arm[1] * arm[1] + weighted_arm[2] * arm[2];
    for (int a = 0, k = 0; a < 3; ++a) {
      const Number weighted_across = weight2 * across[a], weighted_direction = weight2 * direction[a];
      sums.turn[k] += arm2;
      sums.shift[k] += weight2;
      for (int b = a; b < 3; ++b, ++k) {
        sums.turn[k] -= weighted_arm[a] * arm[b] + weighted_across * across[b];
        sums.shift[k] -= weighted_direction * direction[b];
      }
      for (int b = 0; b < 3; ++b) sums.turn_and_shift[3 * a + b] -= weighted_across * direction[b];
    }
    sums.turn_and_shift[1] -= weighted_arm[2];
    sums.turn_and_shift[2] += weighted_arm[1];
    sums.turn_and_shift[3] += weighted_arm[2];
    sums.turn_and_shift[5] -= weighted_arm[0];
    sums.turn_and_shift[6] -= weighted_arm[1];
    sums.turn_and_shift[7] += weighted_arm[0];
    const Number along = direction[0] * chord[0] + direction[1] * chord[1] + direction[2] * chord[2];
    Number pull[3], turn[3];
    for (int k = 0; k < 3; ++k) pull[k] = weight * (chord[k] - along * direction[k]);
    cross(arm, pull, turn);
    for (int k = 0; k < 3; ++k) {
      sums.gradient[k] += turn[k];
      sums.gradient[3 + k] += pull[k];
    }
  }
  return true;
}

/// Sums over all pairs.
template <bool kWithEquations>
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] void add_all(std::span<const Eigen::Vector3d> points,
                                                      std::span<const Eigen::Vector3d> rays, const ChordPoint& at,
                                                      ChordSums<double>& sums) {
  ChordSums<Lanes> of_lanes;
  for_each_in_lanes(
      points.size(),
      [&]<typename Number>(std::size_t i) __attribute__((always_inline)) {
        if constexpr (std::is_same_v<Number, Lanes>)
          return add_pairs<kWithEquations>(&points[i], &rays[i], at, of_lanes);
        return add_pairs<kWithEquations>(&points[i], &rays[i], at, sums);
      },
      // A board point in the centre of projection has no direction.
      [&](std::size_t) { sums.cost += at.scale > 0 ? at.scale * at.scale : 4.0; });
  sums.cost += of_lanes.cost.sum();
  if constexpr (kWithEquations) {
    for (int k = 0; k < 6; ++k) {
      sums.turn[k] += of_lanes.turn[k].sum();
      sums.shift[k] += of_lanes.shift[k].sum();
      sums.gradient[k] += of_lanes.gradient[k].sum();
    }
    for (int k = 0; k < 9; ++k) sums.turn_and_shift[k] += of_lanes.turn_and_shift[k].sum();
  }
}

/// Cost of a pose, and its equations when asked for.
double chord_cost(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> rays, const Rigid3& pose,
                  double scale, PoseEquations* equations = nullptr) {
  const ChordPoint at{pose.rotation.toRotationMatrix(), pose.translation, scale};
  ChordSums<double> sums;
  if (!equations) {
    add_all<false>(points, rays, at, sums);
    return sums.cost;
  }
  add_all<true>(points, rays, at, sums);
  for (int a = 0, k = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b, ++k) {
      equations->hessian(b, a) = sums.turn[k];
      equations->hessian(3 + b, 3 + a) = sums.shift[k];
    }
    for (int b = 0; b < 3; ++b) equations->hessian(3 + b, a) = sums.turn_and_shift[3 * a + b];
  }
  equations->gradient = Eigen::Map<const Vector6>(sums.gradient);
  return sums.cost;
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
      const SmallCholesky<6> factor(damped);
      if (!factor.positive()) {
        lambda *= 10.0;
        continue;
      }
      const Vector6 step = factor.solve(-equations.gradient);
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
