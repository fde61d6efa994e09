// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/manifold.h>

#include "unknowns.hpp"

namespace raybundle {

/// A PoseArray whose steps are the motions of perturbed(), or some components of them.
///
/// Cost functions put the derivative by the six motions into the first six of the seven Jacobian columns and leave the
/// last one zero; PlusJacobian just selects, so that no derivative by quaternion entries is ever formed.
class PoseManifold final : public ceres::Manifold {
 public:
  /// @param free  the components of the motion that may move, ascending
  explicit PoseManifold(std::vector<int> free) : free_(std::move(free)) {}

  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return static_cast<int>(free_.size()); }

  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t k = 0; k < free_.size(); ++k) motion[free_[k]] = delta[k];
    const PoseArray moved = array_from(perturbed(rigid_from(x), motion));
    std::copy(moved.begin(), moved.end(), x_plus_delta);
    return true;
  }

  bool PlusJacobian(const double*, double* jacobian) const override {
    std::fill_n(jacobian, 7 * free_.size(), 0.0);
    for (std::size_t k = 0; k < free_.size(); ++k) jacobian[free_[k] * free_.size() + k] = 1.0;
    return true;
  }

  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Eigen::Matrix<double, 6, 1> motion = motion_between(rigid_from(x), rigid_from(y));
    for (std::size_t k = 0; k < free_.size(); ++k) y_minus_x[k] = motion[free_[k]];
    return true;
  }

  bool MinusJacobian(const double*, double* jacobian) const override {
    std::fill_n(jacobian, 7 * free_.size(), 0.0);
    for (std::size_t k = 0; k < free_.size(); ++k) jacobian[7 * k + free_[k]] = 1.0;
    return true;
  }

 private:
  std::vector<int> free_;
};

}  // namespace raybundle
