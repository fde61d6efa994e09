// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "raybundle/camera/camera_model.hpp"
#include "raybundle/camera/unified_sphere.hpp"

namespace raybundle {

/// Two unit spheres, xi apart, then a pinhole alpha / (1 - alpha) behind the second:
///
///   d1 = |(x, y, z)|,  ζ = xi d1 + z,  d2 = √(x² + y² + ζ²)
///   plane = (x, y) / (alpha d2 + (1 - alpha) ζ)
///
/// Source: Usenko, Demmel and Cremers, "The double sphere camera model", 3DV 2018.
/// Domain: where ζ > -w1 d2 and the first sphere is seen from its outside, d1 + xi z > 0. Deviation: the paper's bound
/// z > -w2 d1 is another one unless xi = 0 or w1 = 1, sometimes stricter and sometimes beyond the fold; here is the
/// exact one.
/// The start shape is close to an equidistant lens. Not xi = 0: there the model is the unified one, xi moves no pixel
/// that focal length and alpha together could not, and a solve that starts there stays there.
struct DoubleSphere {
  static constexpr std::string_view kName = "double_sphere";
  static constexpr std::array<std::string_view, 2> kShapeNames{"xi", "alpha"};
  static constexpr std::array<double, 2> kStartShape{-0.2, 0.6};
  static constexpr std::array kExamples{ExampleShape<2>{{-0.2, 0.6}, 1.9}, ExampleShape<2>{{0.3, 0.55}, 2.2},
                                        ExampleShape<2>{{-0.1, 0.3}, 1.5}, ExampleShape<2>{{0.05, -0.2}, 1.0}};
  // At xi = 0 the model folds, and nearly the same lens lies on both sides of it; published lenses have -0.3 to 0.
  static constexpr std::array kExpected{ExpectedCoefficient{"xi", -0.2, 0.2}};
  static constexpr std::array kForeignNames{ForeignName{"kalibr", "ds-none"}, ForeignName{"basalt", "ds"}};

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane) {
    using std::sqrt;
    const T d1 = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    if (!(d1 + shape[0] * ray[2] > T(0))) return false;
    const T point[3] = {ray[0], ray[1], shape[0] * d1 + ray[2]};
    return UnifiedSphere<T>{shape[1], T(1) - shape[1], T(1)}.project(point, plane);
  }

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane, T* plane_wrt_ray, T* plane_wrt_shape) {
    using std::sqrt;
    const T xi = shape[0];
    const T d1 = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    if (!(d1 + xi * ray[2] > T(0))) return false;
    const T point[3] = {ray[0], ray[1], xi * d1 + ray[2]};
    T wrt_point[6];
    T wrt_a_b[4];
    T wrt_beta[2];
    if (!UnifiedSphere<T>{shape[1], T(1) - shape[1], T(1)}.project(point, plane, wrt_point, wrt_a_b, wrt_beta))
      return false;
    const T xi_over_d1 = xi / d1;
    for (int axis = 0; axis < 2; ++axis) {
      const T wrt_z = wrt_point[3 * axis + 2];
      for (int i = 0; i < 3; ++i) plane_wrt_ray[3 * axis + i] = wrt_z * xi_over_d1 * ray[i];
      plane_wrt_ray[3 * axis] += wrt_point[3 * axis];
      plane_wrt_ray[3 * axis + 1] += wrt_point[3 * axis + 1];
      plane_wrt_ray[3 * axis + 2] += wrt_z;
      plane_wrt_shape[2 * axis] = wrt_z * d1;
      plane_wrt_shape[2 * axis + 1] = wrt_a_b[2 * axis] - wrt_a_b[2 * axis + 1];
    }
    return true;
  }

  static bool ray_from_plane(const double* shape, const double* plane, double* ray) {
    double point[3];
    return second_sphere(shape).unproject(plane, point) && ray_from_point(shape[0], point, ray);
  }

  static double max_angle_rad(const double* shape) {
    const double xi = shape[0];
    if (!(1.0 + xi > 0)) return 0.0;
    const double angle = second_sphere(shape).max_angle_rad();
    const double point[3] = {std::sin(angle), 0.0, std::cos(angle)};
    double ray[3];
    if (!ray_from_point(xi, point, ray)) return std::acos(-1.0 / xi);  // the rim of the first sphere comes before
    return std::atan2(ray[0], ray[2]);
  }

 private:
  static UnifiedSphere<double> second_sphere(const double* shape) { return {shape[1], 1.0 - shape[1], 1.0}; }

  /// Unit ray whose shift by xi along z has the direction of `point`: where that line leaves the first sphere.
  static bool ray_from_point(double xi, const double* point, double* ray) {
    const double r2 = point[0] * point[0] + point[1] * point[1];
    const double norm2 = r2 + point[2] * point[2];
    const double root2 = point[2] * point[2] + (1.0 - xi * xi) * r2;
    if (!(1.0 + xi > 0) || !(root2 >= 0)) return false;
    const double scale = (xi * point[2] + std::sqrt(root2)) / norm2;
    if (!(scale > 0)) return false;
    ray[0] = scale * point[0];
    ray[1] = scale * point[1];
    ray[2] = scale * point[2] - xi;
    return true;
  }
};
static_assert(CameraModel<DoubleSphere>);

}  // namespace raybundle
