// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "raybundle/camera/camera_model.hpp"
#include "raybundle/camera/plane_distortion.hpp"
#include "raybundle/camera/unified_sphere.hpp"

namespace raybundle {

/// Unit sphere, pinhole xi behind its centre, then radial and decentring distortion:
///
///   (u, v) = (x, y) / (z + xi |(x, y, z)|),  r² = u² + v²,  s = 1 + k1 r² + k2 r⁴
///   x' = s u + 2 p1 u v + p2 (r² + 2 u²)
///   y' = s v + p1 (r² + 2 v²) + 2 p2 u v
///
/// Source: Mei and Rives, "Single view point omnidirectional camera calibration from planar grids", ICRA 2007;
/// terms and order as in cv::omnidir with zero skew.
/// Domain: z > -xi d for xi <= 1, z > -d / xi above, d = |(x, y, z)|; and up to where r s(r) folds back.
/// The start shape is the stereographic lens, radius tan(θ/2): half as steep as the angle itself.
struct Unified {
  static constexpr std::string_view kName = "unified";
  static constexpr std::array<std::string_view, 5> kShapeNames{"xi", "k1", "k2", "p1", "p2"};
  static constexpr std::array<double, 5> kStartShape{1.0, 0.0, 0.0, 0.0, 0.0};
  static constexpr std::array kExamples{
      ExampleShape<5>{{0.9, -0.1, 0.02, 0.0005, -0.0003}, 1.6}, ExampleShape<5>{{1.6, 0.05, 0.3, -0.001, 0.0007}, 1.8},
      ExampleShape<5>{{0.4, -0.05, 0.01, 0.0, 0.0}, 1.3}, ExampleShape<5>{{-0.1, 0.02, 0.01, 0.001, 0.001}, 0.9}};
  // fx, fy, k1 and k2 nearly make good for any xi; of real lenses it lies between 0 (rectilinear) and 3.
  static constexpr std::array kExpected{ExpectedCoefficient{"xi", 1.0, 1.0}};
  static constexpr std::array kForeignNames{ForeignName{"opencv_omnidir", "omnidir"},
                                            ForeignName{"kalibr", "omni-radtan"}, ForeignName{"camodocal", "MEI"}};

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane) {
    T ideal[2];
    if (!UnifiedSphere<T>{shape[0], T(1), T(1)}.project(ray, ideal)) return false;
    return PlaneDistortion<4>::distort(shape + 1, ideal, plane);
  }

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane, T* plane_wrt_ray, T* plane_wrt_shape) {
    T ideal[2];
    T ideal_wrt_ray[6];
    T ideal_wrt_a_b[4];
    T ideal_wrt_beta[2];
    T wrt_ideal[4];
    if (!UnifiedSphere<T>{shape[0], T(1), T(1)}.project(ray, ideal, ideal_wrt_ray, ideal_wrt_a_b, ideal_wrt_beta))
      return false;
    if (!PlaneDistortion<4>::distort(shape + 1, ideal, plane, wrt_ideal, plane_wrt_shape + 1, 5)) return false;
    for (int axis = 0; axis < 2; ++axis) {
      const T wrt_u = wrt_ideal[2 * axis];
      const T wrt_v = wrt_ideal[2 * axis + 1];
      for (int i = 0; i < 3; ++i) plane_wrt_ray[3 * axis + i] = wrt_u * ideal_wrt_ray[i] + wrt_v * ideal_wrt_ray[3 + i];
      plane_wrt_shape[5 * axis] = wrt_u * ideal_wrt_a_b[0] + wrt_v * ideal_wrt_a_b[2];
    }
    return true;
  }

  static bool ray_from_plane(const double* shape, const double* plane, double* ray) {
    double ideal[2];
    if (!PlaneDistortion<4>::undistort(shape + 1, plane, ideal)) return false;
    if (!sphere(shape).unproject(ideal, ray)) return false;
    const double inverse_norm = 1.0 / std::sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    for (int i = 0; i < 3; ++i) ray[i] *= inverse_norm;
    return true;
  }

  static double max_angle_rad(const double* shape) {
    const double of_sphere = sphere(shape).max_angle_rad();
    const double plane[2] = {PlaneDistortion<4>::max_radius(shape + 1), 0.0};
    double ray[3];
    if (!std::isfinite(plane[0]) || !sphere(shape).unproject(plane, ray)) return of_sphere;
    return std::min(of_sphere, std::atan2(ray[0], ray[2]));
  }

 private:
  static UnifiedSphere<double> sphere(const double* shape) { return {shape[0], 1.0, 1.0}; }
};
static_assert(CameraModel<Unified>);

}  // namespace raybundle
