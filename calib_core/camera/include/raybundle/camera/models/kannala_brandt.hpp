// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "raybundle/camera/camera_model.hpp"
#include "raybundle/camera/radial.hpp"

namespace raybundle {

/// Fisheye: radius is an odd polynomial of the angle off the axis, r = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸).
/// Source: Kannala and Brandt, "A generic camera model and calibration method for conventional, wide-angle, and
/// fish-eye lenses", PAMI 2006, eq. 6, radial part; the same as cv::fisheye with zero skew.
struct KannalaBrandt {
  static constexpr std::string_view kName = "kannala_brandt";
  static constexpr std::array<std::string_view, 4> kShapeNames{"k1", "k2", "k3", "k4"};
  static constexpr std::array<double, 4> kStartShape{0, 0, 0, 0};
  static constexpr std::array kExamples{ExampleShape<4>{{0, 0, 0, 0}, 1.7},
                                        ExampleShape<4>{{-0.02, 0.005, -0.003, 0.0004}, 1.6},
                                        ExampleShape<4>{{0.08, -0.02, 0.004, -0.0005}, 1.4}};
  static constexpr std::array kForeignNames{
      ForeignName{"opencv_fisheye", "fisheye"},   ForeignName{"kalibr", "pinhole-equi"},
      ForeignName{"ros", "equidistant"},          ForeignName{"basalt", "kb4"},
      ForeignName{"camodocal", "KANNALA_BRANDT"}, ForeignName{"colmap", "OPENCV_FISHEYE"}};

  template <typename T>
  static bool plane_from_ray(const T* k, const T* ray, T* plane) {
    using std::atan2, std::sqrt;
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (rho2 < T(1e-24) * ray[2] * ray[2]) {  // on the axis: the first-order limit keeps derivatives finite
      if (!(ray[2] > T(0))) return false;
      plane[0] = ray[0] / ray[2];
      plane[1] = ray[1] / ray[2];
      return true;
    }
    const T rho = sqrt(rho2);
    const T angle = atan2(rho, ray[2]);
    const T scale = radius(k, angle) / rho;
    plane[0] = scale * ray[0];
    plane[1] = scale * ray[1];
    return true;
  }

  template <typename T>
  static bool plane_from_ray(const T* k, const T* ray, T* plane, T* plane_wrt_ray, T* plane_wrt_shape) {
    using std::atan2, std::sqrt;
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const bool on_axis = rho2 < T(1e-24) * ray[2] * ray[2];
    if (on_axis && !(ray[2] > T(0))) return false;
    const T rho = sqrt(rho2);
    const T inverse_rho = T(1) / rho;
    const T cosine = on_axis ? T(1) : ray[0] * inverse_rho;  // of the azimuth
    const T sine = on_axis ? T(0) : ray[1] * inverse_rho;
    const T angle = atan2(rho, ray[2]);
    const T r = radius(k, angle);
    plane[0] = r * cosine;
    plane[1] = r * sine;

    const T inverse_norm2 = T(1) / (rho2 + ray[2] * ray[2]);
    const T slope = radius_slope(k, angle);
    const T tangential = on_axis ? T(1) / ray[2] : r * inverse_rho;
    const T radial = slope * ray[2] * inverse_norm2;
    const T along_axis = -slope * rho * inverse_norm2;
    const T difference = radial - tangential;
    plane_wrt_ray[0] = tangential + difference * cosine * cosine;
    plane_wrt_ray[1] = plane_wrt_ray[3] = difference * cosine * sine;
    plane_wrt_ray[2] = along_axis * cosine;
    plane_wrt_ray[4] = tangential + difference * sine * sine;
    plane_wrt_ray[5] = along_axis * sine;

    const T angle2 = angle * angle;
    T power = angle;
    for (int i = 0; i < 4; ++i) {
      power *= angle2;
      plane_wrt_shape[i] = power * cosine;
      plane_wrt_shape[4 + i] = power * sine;
    }
    return true;
  }

  static bool ray_from_plane(const double* k, const double* plane, double* ray) {
    const double r = std::hypot(plane[0], plane[1]);
    const auto profile = [k](double angle) { return ValueAndSlope{radius(k, angle), radius_slope(k, angle)}; };
    double angle = solve_increasing(profile, r, 0.0, M_PI, std::min(r, M_PI));
    const bool first = std::abs(radius(k, angle) - r) <= 1e-12 * r && grows_up_to(k, angle);
    if (!first) {  // near or beyond the end of the field
      const double high = max_angle_rad(k);
      if (!(r <= radius(k, high))) return false;
      angle = solve_increasing(profile, r, 0.0, high, std::min(r, high));
    }
    const double scale = r > 0 ? std::sin(angle) / r : 1.0;
    ray[0] = scale * plane[0];
    ray[1] = scale * plane[1];
    ray[2] = std::cos(angle);
    return true;
  }

  static double max_angle_rad(const double* k) {
    const double root = first_root(bernstein_to_limit(slope_in_squares(k), M_PI * M_PI));
    return root < 1.0 ? M_PI * std::sqrt(root) : M_PI;
  }

  static bool grows_up_to(const double* k, double angle) {
    return all_positive(bernstein_to_limit(slope_in_squares(k), angle * angle));
  }

 private:
  /// The radius' slope in powers of the angle squared.
  static std::array<double, 5> slope_in_squares(const double* k) {
    return {1.0, 3 * k[0], 5 * k[1], 7 * k[2], 9 * k[3]};
  }

  template <typename T>
  static T radius(const T* k, const T& angle) {
    const T a2 = angle * angle;
    return angle * (T(1) + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))));
  }

  template <typename T>
  static T radius_slope(const T* k, const T& angle) {
    const T a2 = angle * angle;
    return T(1) + a2 * (T(3) * k[0] + a2 * (T(5) * k[1] + a2 * (T(7) * k[2] + a2 * T(9) * k[3])));
  }
};
static_assert(CameraModel<KannalaBrandt>);

}  // namespace raybundle
