// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "raybundle/camera/camera_model.hpp"

namespace raybundle {

/// Fisheye with one parameter, the field of view of the ideal lens: with ρ = √(x² + y²),
///
///   r = arctan(2 ρ tan(w/2) / z) / w,  plane = r (x, y) / ρ
///
/// Source: Devernay and Faugeras, "Straight lines have to be straight", Machine Vision and Applications 2001.
/// Deviation: the arctangent of (ρ, z) as two arguments continues the profile beyond 90° and up to r = π / w.
/// Domain: every ray but the one straight behind, |w| < π [rad]; the sign of w has no meaning. w -> 0 is the pinhole.
/// The start shape, 2 tan(w/2) = 1, is the equidistant lens, radius θ / w.
struct FieldOfView {
  static constexpr std::string_view kName = "field_of_view";
  static constexpr std::array<std::string_view, 1> kShapeNames{"w"};
  static constexpr std::array<double, 1> kStartShape{0.92729521800161219};
  static constexpr std::array kExamples{ExampleShape<1>{{0.92}, 1.8}, ExampleShape<1>{{1.4}, 1.6},
                                        ExampleShape<1>{{0.3}, 1.2}, ExampleShape<1>{{1e-7}, 1.0}};
  static constexpr std::array kForeignNames{ForeignName{"kalibr", "pinhole-fov"}, ForeignName{"colmap", "FOV"}};

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane) {
    T gain, angle;
    return plane_from_ray(shape, ray, plane, gain, angle);
  }

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane, T* plane_wrt_ray, T* plane_wrt_shape) {
    T gain, angle;
    if (!plane_from_ray(shape, ray, plane, gain, angle)) return false;
    using std::sqrt;
    const T w = shape[0];
    const T z = ray[2];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const bool on_axis = is_on_axis(rho2, z);
    const T rho = sqrt(rho2);
    const T cosine = on_axis ? T(1) : ray[0] / rho;  // of the azimuth
    const T sine = on_axis ? T(0) : ray[1] / rho;

    T tangential;  // r / ρ
    T radial;      // dr/dρ
    T r_wrt_z;
    T r_wrt_w;
    if (is_small(w)) {
      const T t2 = rho2 / (z * z);
      tangential = (1.0 + w * w * (1.0 / 12 - t2 / 3)) / z;
      radial = (1.0 + w * w * (1.0 / 12 - t2)) / z;
      r_wrt_w = 2.0 * w * (1.0 / 12 - t2 / 3) * rho / z;
      r_wrt_z = -radial * rho / z;
    } else {
      const T inverse = 1.0 / (gain * gain * rho2 + z * z);
      const T r = angle / w;
      tangential = on_axis ? gain / (w * z) : r / rho;
      radial = gain * z * inverse / w;
      r_wrt_z = -gain * rho * inverse / w;
      const T gain_wrt_w = 1.0 + 0.25 * gain * gain;
      r_wrt_w = (rho * z * inverse * gain_wrt_w - r) / w;
    }
    const T difference = radial - tangential;
    plane_wrt_ray[0] = tangential + difference * cosine * cosine;
    plane_wrt_ray[1] = plane_wrt_ray[3] = difference * cosine * sine;
    plane_wrt_ray[2] = r_wrt_z * cosine;
    plane_wrt_ray[4] = tangential + difference * sine * sine;
    plane_wrt_ray[5] = r_wrt_z * sine;
    plane_wrt_shape[0] = r_wrt_w * cosine;
    plane_wrt_shape[1] = r_wrt_w * sine;
    return true;
  }

  static bool ray_from_plane(const double* shape, const double* plane, double* ray) {
    const double w = std::abs(shape[0]);
    const double r = std::hypot(plane[0], plane[1]);
    const double angle = r * w;
    if (!(w < M_PI) || !(angle < M_PI)) return false;
    // (sin(r w), gain cos(r w)) / w, with the limit of small w where both terms of the ray vanish
    const double gain_over_w = is_small(w) ? 1.0 + w * w / 12 : 2.0 * std::tan(0.5 * w) / w;
    const double sine_over_r_w = angle < 1e-4 ? 1.0 - angle * angle / 6 : std::sin(angle) / angle;
    const double z = gain_over_w * std::cos(angle);
    const double inverse_norm = 1.0 / std::hypot(sine_over_r_w * r, z);
    ray[0] = inverse_norm * sine_over_r_w * plane[0];
    ray[1] = inverse_norm * sine_over_r_w * plane[1];
    ray[2] = inverse_norm * z;
    return true;
  }

  static double max_angle_rad(const double* shape) {
    const double w = std::abs(shape[0]);
    if (!(w < M_PI)) return 0.0;
    return is_small(w) ? M_PI_2 : M_PI;
  }

 private:
  /// Also gives 2 tan(w/2) and the arctangent, where w is not small.
  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane, T& gain, T& angle) {
    using std::atan2, std::sqrt, std::tan;
    const T& w = shape[0];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!valid(w, rho2, ray[2])) return false;
    T scale;
    if (is_small(w)) {
      gain = angle = T(0);
      scale = (T(1) + w * w * (T(1.0 / 12) - rho2 / (T(3) * ray[2] * ray[2]))) / ray[2];
    } else {
      const T rho = sqrt(rho2);
      gain = T(2) * tan(T(0.5) * w);
      angle = atan2(gain * rho, ray[2]);
      scale = is_on_axis(rho2, ray[2]) ? gain / (w * ray[2]) : angle / (w * rho);
    }
    plane[0] = scale * ray[0];
    plane[1] = scale * ray[1];
    return true;
  }

  /// Below, the arctangent is replaced by its series in w, exact to 1e-13 up to 89.9° off the axis.
  template <typename T>
  static bool is_small(const T& w) {
    return w < T(1e-6) && w > T(-1e-6);
  }

  template <typename T>
  static bool is_on_axis(const T& rho2, const T& z) {
    return rho2 < T(1e-24) * z * z;
  }

  template <typename T>
  static bool valid(const T& w, const T& rho2, const T& z) {
    if (!(w < T(M_PI) && w > T(-M_PI))) return false;
    return (!is_small(w) && !is_on_axis(rho2, z)) || z > T(0);
  }
};
static_assert(CameraModel<FieldOfView>);

}  // namespace raybundle
