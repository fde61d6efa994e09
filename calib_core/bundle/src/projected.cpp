// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "projected.hpp"

#include <limits>

#include "raybundle/camera/lanes.hpp"
#include "raybundle/geometry/target_clones.hpp"

namespace raybundle {
namespace {

// Plane point of the ray at `row`, or of the Lanes::kCount from there on.
template <CameraModel M, typename Number>
[[gnu::always_inline]] inline bool project_at(const double* shape, const Eigen::MatrixX3d& rays, Eigen::Index row,
                                              Eigen::MatrixX2d& plane) {
  constexpr int n = kShapeSize<M>;
  Number model_shape[n > 0 ? n : 1];
  for (int k = 0; k < n; ++k) model_shape[k] = Number(shape[k]);
  Number ray[3], at[2];
  for (int k = 0; k < 3; ++k) load(&rays(row, k), ray[k]);
  if (!M::plane_from_ray(model_shape, ray, at)) return false;
  for (int k = 0; k < 2; ++k) store(at[k], &plane(row, k));
  return true;
}

template <CameraModel M>
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] void project(const double* shape, const Eigen::MatrixX3d& rays,
                                                      Eigen::MatrixX2d& plane) {
  for_each_in_lanes(
      rays.rows(),
      [&]<typename Number>(Eigen::Index row)
          __attribute__((always_inline)) { return project_at<M, Number>(shape, rays, row, plane); },
      [&](Eigen::Index row) { plane.row(row).setConstant(std::numeric_limits<double>::quiet_NaN()); });
}

}  // namespace

Eigen::MatrixX2d projected(const Camera& camera, const Eigen::MatrixX3d& points_in_camera) {
  Eigen::MatrixX2d pixels(points_in_camera.rows(), 2);
  const double* parameters = camera.parameters.data();
  with_model(camera.model, [&]<CameraModel M>() { project<M>(parameters + 4, points_in_camera, pixels); });
  for (int axis = 0; axis < 2; ++axis) {
    pixels.col(axis) = (parameters[axis] * pixels.col(axis).array() + parameters[2 + axis]).matrix();
  }
  return pixels;
}

}  // namespace raybundle
