// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
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

  static bool plane_from_ray(const double* k, const double* ray, double* plane, double* plane_wrt_ray,
                             double* plane_wrt_shape) {
    const double rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const bool on_axis = rho2 < 1e-24 * ray[2] * ray[2];
    if (on_axis && !(ray[2] > 0)) return false;
    const double rho = std::sqrt(rho2);
    const double cosine = on_axis ? 1.0 : ray[0] / rho;  // of the azimuth
    const double sine = on_axis ? 0.0 : ray[1] / rho;
    const double angle = std::atan2(rho, ray[2]);
    const double r = radius(k, angle);
    plane[0] = r * cosine;
    plane[1] = r * sine;

    const double inverse_norm2 = 1.0 / (rho2 + ray[2] * ray[2]);
    const double slope = radius_slope(k, angle);
    const double tangential = on_axis ? 1.0 / ray[2] : r / rho;
    const double radial = slope * ray[2] * inverse_norm2;
    const double along_axis = -slope * rho * inverse_norm2;
    const double difference = radial - tangential;
    plane_wrt_ray[0] = tangential + difference * cosine * cosine;
    plane_wrt_ray[1] = plane_wrt_ray[3] = difference * cosine * sine;
    plane_wrt_ray[2] = along_axis * cosine;
    plane_wrt_ray[4] = tangential + difference * sine * sine;
    plane_wrt_ray[5] = along_axis * sine;

    const double angle2 = angle * angle;
    double power = angle;
    for (int i = 0; i < 4; ++i) {
      power *= angle2;
      plane_wrt_shape[i] = power * cosine;
      plane_wrt_shape[4 + i] = power * sine;
    }
    return true;
  }

  static bool ray_from_plane(const double* k, const double* plane, double* ray) {
    const double r = std::hypot(plane[0], plane[1]);
    const double high = max_angle_rad(k);
    if (!(r <= radius(k, high))) return false;
    const auto profile = [k](double angle) { return ValueAndSlope{radius(k, angle), radius_slope(k, angle)}; };
    const double angle = solve_increasing(profile, r, 0.0, high, std::min(r, high));
    const double scale = r > 0 ? std::sin(angle) / r : 1.0;
    ray[0] = scale * plane[0];
    ray[1] = scale * plane[1];
    ray[2] = std::cos(angle);
    return true;
  }

  static double max_angle_rad(const double* k) {
    const std::array<double, 5> slope{1.0, 3 * k[0], 5 * k[1], 7 * k[2], 9 * k[3]};  // in powers of the angle squared
    const double root = first_root(bernstein_to_limit(slope, M_PI * M_PI));
    return root < 1.0 ? M_PI * std::sqrt(root) : M_PI;
  }

 private:
  template <typename T>
  static T radius(const T* k, const T& angle) {
    const T a2 = angle * angle;
    return angle * (T(1) + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))));
  }

  static double radius_slope(const double* k, double angle) {
    const double a2 = angle * angle;
    return 1.0 + a2 * (3 * k[0] + a2 * (5 * k[1] + a2 * (7 * k[2] + a2 * 9 * k[3])));
  }
};
static_assert(CameraModel<KannalaBrandt>);

}  // namespace raybundle
