// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "raybundle/camera/camera_model.hpp"
#include "raybundle/camera/unified_sphere.hpp"

namespace raybundle {

/// Projection through an ellipsoid:
///
///   d = √(beta (x² + y²) + z²),  plane = (x, y) / (alpha d + (1 - alpha) z)
///
/// Source: Khomutenko, Garcia and Martinet, "An enhanced unified camera model", RA-L 2016.
/// Domain: beta > 0, and z > -w d with w = (1 - alpha) / alpha for alpha > 0.5, else alpha / (1 - alpha).
/// The start shape is the stereographic lens, radius 2 tan(θ/2).
struct ExtendedUnified {
  static constexpr std::string_view kName = "extended_unified";
  static constexpr std::array<std::string_view, 2> kShapeNames{"alpha", "beta"};
  static constexpr std::array<double, 2> kStartShape{0.5, 1.0};
  static constexpr std::array kExamples{ExampleShape<2>{{0.6, 1.1}, 1.9}, ExampleShape<2>{{0.5, 0.9}, 2.5},
                                        ExampleShape<2>{{0.35, 1.3}, 1.6}, ExampleShape<2>{{-0.15, 1.0}, 1.0}};
  // Of a lens that is nearly rectilinear, alpha is nearly zero and beta means nothing.
  static constexpr std::array kExpected{ExpectedCoefficient{"beta", 1.0, 1.0}};
  static constexpr std::array kForeignNames{ForeignName{"kalibr", "eucm-none"}, ForeignName{"basalt", "eucm"},
                                            ForeignName{"colmap", "EUCM"}};

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane) {
    if (!(shape[1] > T(0))) return false;
    return UnifiedSphere<T>{shape[0], T(1) - shape[0], shape[1]}.project(ray, plane);
  }

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane, T* plane_wrt_ray, T* plane_wrt_shape) {
    T wrt_a_b[4];
    T wrt_beta[2];
    if (!(shape[1] > T(0))) return false;
    const UnifiedSphere<T> ellipsoid{shape[0], T(1) - shape[0], shape[1]};
    if (!ellipsoid.project(ray, plane, plane_wrt_ray, wrt_a_b, wrt_beta)) return false;
    for (int axis = 0; axis < 2; ++axis) {
      plane_wrt_shape[2 * axis] = wrt_a_b[2 * axis] - wrt_a_b[2 * axis + 1];
      plane_wrt_shape[2 * axis + 1] = wrt_beta[axis];
    }
    return true;
  }

  static bool ray_from_plane(const double* shape, const double* plane, double* ray) {
    double point[3];
    if (!ellipsoid(shape).unproject(plane, point)) return false;
    const double inverse_norm = 1.0 / std::sqrt(point[0] * point[0] + point[1] * point[1] + point[2] * point[2]);
    for (int i = 0; i < 3; ++i) ray[i] = inverse_norm * point[i];
    return true;
  }

  static double max_angle_rad(const double* shape) { return ellipsoid(shape).max_angle_rad(); }

 private:
  static UnifiedSphere<double> ellipsoid(const double* shape) { return {shape[0], 1.0 - shape[0], shape[1]}; }
};
static_assert(CameraModel<ExtendedUnified>);

}  // namespace raybundle
