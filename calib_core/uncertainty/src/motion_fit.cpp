// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "motion_fit.hpp"

#include <Eigen/QR>

#include "sensitivity.hpp"

namespace raybundle {

Eigen::Matrix<double, 6, Eigen::Dynamic> MotionFit::undoing() const {
  const Eigen::Matrix<double, 6, 1> scale = normal.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix<double, 6, 6>> solver;
  solver.setThreshold(1e-12);
  solver.compute(scale.asDiagonal() * normal * scale.asDiagonal());
  return -(scale.asDiagonal() * solver.solve(scale.asDiagonal() * with_changes));
}

Eigen::Matrix<double, 2, 6> by_motion_at(const Eigen::Matrix<double, 2, 3>& by_ray, const Eigen::Vector3d& ray,
                                         double range_m) {
  Eigen::Matrix<double, 3, 6> motion = by_motion_of_surroundings(ray);
  motion.rightCols<3>() /= range_m;  // the pixel depends on the direction only: everything is scaled to the ray
  return by_ray * motion;
}

}  // namespace raybundle
