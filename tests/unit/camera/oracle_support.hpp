// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

#include "law_support.hpp"

namespace raybundle {

/// What another library says about a set of rays: pixels, and Jacobians in our order of columns.
struct Opinion {
  Eigen::Matrix<double, Eigen::Dynamic, 2> pixels;   ///< N×2
  Eigen::Matrix<double, Eigen::Dynamic, 3> wrt_ray;  ///< 2N×3, rows u, v of each ray in turn
  Eigen::MatrixXd wrt_parameters;                    ///< 2N×n, columns as in Camera::parameters
};

/// Rays at different distances: an oracle that divides by z must see more than unit vectors.
inline std::vector<Eigen::Vector3d> points_up_to(double half_angle_rad) {
  std::vector<Eigen::Vector3d> points = rays_up_to(half_angle_rad, 200);
  points.erase(points.begin(), points.begin() + 3);  // closer to the axis than the oracles are careful with
  for (std::size_t i = 0; i < points.size(); ++i) points[i] *= 0.3 + 0.05 * static_cast<double>(i);
  return points;
}

/// Asserts that our pixels and Jacobians are theirs. 1e-9 px is rounding of two different orders of evaluation;
/// Jacobians are compared relative to their largest entry.
template <CameraModel M>
void expect_same(const Camera& camera, const std::vector<Eigen::Vector3d>& points, const Opinion& theirs) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
    Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> wrt_parameters;
    ASSERT_TRUE(pixel_from_ray<M>(camera.parameters.data(), points[i], pixel, wrt_ray, wrt_parameters));
    EXPECT_LT((pixel - theirs.pixels.row(row).transpose()).norm(), 1e-9) << points[i].transpose();
    const auto their_wrt_ray = theirs.wrt_ray.middleRows<2>(2 * row);
    EXPECT_LT((wrt_ray - their_wrt_ray).norm(), 1e-9 * (1.0 + their_wrt_ray.norm())) << points[i].transpose();
    const auto their_wrt_parameters = theirs.wrt_parameters.middleRows<2>(2 * row);
    EXPECT_LT((wrt_parameters - their_wrt_parameters).norm(), 1e-9 * (1.0 + their_wrt_parameters.norm()))
        << points[i].transpose();
  }
}

}  // namespace raybundle
