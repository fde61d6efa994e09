// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "raybundle/camera/camera_model.hpp"

namespace raybundle {

/// The lens that a start is searched with, before the model asked for takes over: with d the unit ray, c = d_z and
/// t = 1 - c,
///
///   plane = d_xy (1 + k1 t + k2 t²) / ((1 - alpha) c + alpha).
///
/// alpha = 0 is rectilinear, 1/2 stereographic, about 0.6 equidistant, 0.7 equisolid, 1 orthographic; k1 and k2 bend
/// the profile further. Rays beyond the angle where the radius stops growing do not project. Source: Barreto and
/// Araujo, "Issues on the geometry of central catadioptric image formation", CVPR 2001, eq. 2, with the focal length
/// normalised to the slope on the axis; the polynomial is ours.
struct StartLens {
  static constexpr std::string_view kName = "start_lens";
  static constexpr std::array<std::string_view, 3> kShapeNames{"alpha", "k1", "k2"};
  static constexpr std::array<double, 3> kStartShape{0.5, 0, 0};
  static constexpr std::array kExamples{ExampleShape<3>{{0.6, 0, 0}, 1.8}};
  static constexpr std::array<ForeignName, 0> kForeignNames{};

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane) {
    using std::sqrt;
    const T norm = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    const T c = ray[2] / norm;
    const T t = T(1) - c;
    const T denominator = (T(1) - shape[0]) * c + shape[0];
    if (!(denominator > T(1e-9))) return false;
    const T polynomial = T(1) + t * (shape[1] + t * shape[2]);
    const T scale = polynomial / denominator;
    if (!(profile_slope(shape, c, denominator, polynomial) > T(0))) return false;
    plane[0] = scale * ray[0] / norm;
    plane[1] = scale * ray[1] / norm;
    return true;
  }

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane, T* plane_wrt_ray, T* plane_wrt_shape) {
    using std::sqrt;
    const T nearness = T(1) / sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    const T d[3] = {ray[0] * nearness, ray[1] * nearness, ray[2] * nearness};
    const T c = d[2];
    const T t = T(1) - c;
    const T denominator = (T(1) - shape[0]) * c + shape[0];
    if (!(denominator > T(1e-9))) return false;
    const T polynomial = T(1) + t * (shape[1] + t * shape[2]);
    if (!(profile_slope(shape, c, denominator, polynomial) > T(0))) return false;
    const T inverse = T(1) / denominator;
    const T scale = polynomial * inverse;
    const T scale_wrt_c = (-(shape[1] + T(2) * t * shape[2]) - scale * (T(1) - shape[0])) * inverse;
    for (int axis = 0; axis < 2; ++axis) {
      plane[axis] = scale * d[axis];
      T wrt_direction[3] = {T(0), T(0), d[axis] * scale_wrt_c};
      wrt_direction[axis] = scale;
      const T along = wrt_direction[0] * d[0] + wrt_direction[1] * d[1] + wrt_direction[2] * d[2];
      for (int k = 0; k < 3; ++k) plane_wrt_ray[3 * axis + k] = (wrt_direction[k] - along * d[k]) * nearness;
      plane_wrt_shape[3 * axis + 0] = -d[axis] * scale * t * inverse;
      plane_wrt_shape[3 * axis + 1] = d[axis] * t * inverse;
      plane_wrt_shape[3 * axis + 2] = d[axis] * t * t * inverse;
    }
    return true;
  }

  static bool ray_from_plane(const double* shape, const double* plane, double* ray) {
    const double r = std::hypot(plane[0], plane[1]);
    if (r < 1e-12) {
      ray[0] = plane[0], ray[1] = plane[1], ray[2] = 1.0;
      return true;
    }
    double low = 0.0;  // "projects, to a smaller radius" holds up to the angle looked for and not beyond
    double high = M_PI;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      const double trial[3] = {std::sin(middle), 0, std::cos(middle)};
      double at[2];
      (plane_from_ray(shape, trial, at) && at[0] < r ? low : high) = middle;
    }
    const double trial[3] = {std::sin(low), 0, std::cos(low)};
    double at[2];
    if (!plane_from_ray(shape, trial, at) || std::abs(at[0] - r) > 1e-6 * (1 + r)) return false;
    ray[0] = trial[0] * plane[0] / r;
    ray[1] = trial[0] * plane[1] / r;
    ray[2] = trial[2];
    return true;
  }

  static double max_angle_rad(const double* shape) {
    double low = 0.0;
    double high = M_PI;
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      const double trial[3] = {std::sin(middle), 0, std::cos(middle)};
      double at[2];
      (plane_from_ray(shape, trial, at) ? low : high) = middle;
    }
    return low;
  }

  /// Inverse for k1 = k2 = 0, in closed form.
  static bool ray_from_plane_without_polynomial(double alpha, const double* plane, double* ray) {
    const double r2 = plane[0] * plane[0] + plane[1] * plane[1];
    const double inside = 1 - (2 * alpha - 1) * r2;
    if (!(inside > 0)) return false;
    const double z = (1 - alpha * alpha * r2) / (alpha * std::sqrt(inside) + 1 - alpha);
    const double inverse_norm = 1.0 / std::sqrt(r2 + z * z);
    ray[0] = plane[0] * inverse_norm;
    ray[1] = plane[1] * inverse_norm;
    ray[2] = z * inverse_norm;
    return true;
  }

 private:
  /// Derivative of the radius by the angle, up to a positive factor.
  template <typename T>
  static T profile_slope(const T* shape, const T& c, const T& denominator, const T& polynomial) {
    const T polynomial_wrt_c = -(shape[1] + T(2) * (T(1) - c) * shape[2]);
    return c * polynomial * denominator -
           (T(1) - c * c) * (polynomial_wrt_c * denominator - polynomial * (T(1) - shape[0]));
  }
};
static_assert(CameraModel<StartLens>);

}  // namespace raybundle
