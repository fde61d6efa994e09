// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "raybundle/camera/radial.hpp"

namespace raybundle {

/// The distortion of a plane that brown_conrady, rational, thin_prism and unified have in common, r² = x² + y²:
///
///   s  = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
///   x' = s x + 2 p1 x y + p2 (r² + 2 x²) + s1 r² + s2 r⁴
///   y' = s y + p1 (r² + 2 y²) + 2 p2 x y + s3 r² + s4 r⁴
///
/// The n coefficients stand in OpenCV's order: k1 k2 p1 p2 | k3 | k4 k5 k6 | s1 s2 s3 s4, cut after 4, 5, 8 or 12.
template <int n>
struct PlaneDistortion {
  static_assert(n == 4 || n == 5 || n == 8 || n == 12);
  static constexpr bool kHasDenominator = n >= 8;
  static constexpr bool kHasPrism = n >= 12;

  /// False where the denominator is not positive.
  template <typename T>
  static bool distort(const T* k, const T* plane, T* distorted) {
    const T& x = plane[0];
    const T& y = plane[1];
    const T r2 = x * x + y * y;
    T scale = numerator(k, r2);
    if constexpr (kHasDenominator) {
      const T below = denominator(k, r2);
      if (!(below > T(0))) return false;
      scale = scale / below;
    }
    const T xy2 = T(2) * x * y;
    distorted[0] = scale * x + k[2] * xy2 + k[3] * (r2 + T(2) * x * x);
    distorted[1] = scale * y + k[2] * (r2 + T(2) * y * y) + k[3] * xy2;
    if constexpr (kHasPrism) {
      distorted[0] += r2 * (k[8] + r2 * k[9]);
      distorted[1] += r2 * (k[10] + r2 * k[11]);
    }
    return true;
  }

  /// The same with Jacobians.
  ///
  /// @param wrt_plane  2×2 row-major
  /// @param wrt_k      2×n row-major, row 1 begins `stride` entries after row 0; not written when null
  template <typename T>
  static bool distort(const T* k, const T* plane, T* distorted, T* wrt_plane, T* wrt_k, int stride = n) {
    if (!distort(k, plane, distorted)) return false;
    const T x = plane[0];
    const T y = plane[1];
    const T r2 = x * x + y * y;
    const T inverse_below = kHasDenominator ? T(1) / denominator(k, r2) : T(1);
    const T scale = numerator(k, r2) * inverse_below;
    const T slope = T(2) * (numerator_slope(k, r2) - scale * denominator_slope(k, r2)) * inverse_below;
    const T across = slope * x * y + T(2) * (k[2] * x + k[3] * y);
    wrt_plane[0] = scale + slope * x * x + T(2) * k[2] * y + T(6) * k[3] * x;
    wrt_plane[1] = across;
    wrt_plane[2] = across;
    wrt_plane[3] = scale + slope * y * y + T(6) * k[2] * y + T(2) * k[3] * x;
    if constexpr (kHasPrism) {
      const T prism_x = T(2) * (k[8] + T(2) * r2 * k[9]);
      const T prism_y = T(2) * (k[10] + T(2) * r2 * k[11]);
      wrt_plane[0] += prism_x * x;
      wrt_plane[1] += prism_x * y;
      wrt_plane[2] += prism_y * x;
      wrt_plane[3] += prism_y * y;
    }
    if (wrt_k == nullptr) return true;

    T* row[2] = {wrt_k, wrt_k + stride};
    for (int axis = 0; axis < 2; ++axis) {
      const T radial = plane[axis] * inverse_below * r2;
      row[axis][0] = radial;
      row[axis][1] = radial * r2;
      if constexpr (n >= 5) row[axis][4] = radial * r2 * r2;
      if constexpr (kHasDenominator) {
        for (int i = 0; i < 3; ++i) row[axis][5 + i] = -scale * row[axis][i == 2 ? 4 : i];
      }
    }
    row[0][2] = row[1][3] = T(2) * x * y;
    row[0][3] = r2 + T(2) * x * x;
    row[1][2] = r2 + T(2) * y * y;
    if constexpr (kHasPrism) {
      row[0][8] = row[1][10] = r2;
      row[0][9] = row[1][11] = r2 * r2;
      row[0][10] = row[0][11] = row[1][8] = row[1][9] = T(0);
    }
    return true;
  }

  /// The point that is distorted to `distorted` and is connected with the axis: beyond the radius where the profile
  /// folds, other points may land there too, and they are not returned. False where there is none.
  ///
  /// The radial part is inverted first, in one variable; damped Newton steps in the plane add the other terms. Steps
  /// stay where the Jacobian's determinant is positive.
  static bool undistort(const double* k, const double* distorted, double* plane) {
    const double limit = max_radius(k);
    const double target = std::hypot(distorted[0], distorted[1]);
    const double radius = radius_from_distorted(k, target, limit);
    const double scale = target > 0 ? radius / target : 1.0;
    plane[0] = scale * distorted[0];
    plane[1] = scale * distorted[1];

    const double rounding = 1e-15 * std::max(1.0, target);
    Newton at = newton_at(k, plane, distorted);
    for (int i = 0; i < 50 && at.determinant > 0 && at.error > rounding; ++i) {
      double factor = 1.0;
      double next[2];
      Newton at_next{};
      for (; factor > 1e-6; factor *= 0.5) {
        for (int axis = 0; axis < 2; ++axis) next[axis] = plane[axis] - factor * at.step[axis];
        at_next = newton_at(k, next, distorted);
        if (at_next.determinant > 0 && std::hypot(next[0], next[1]) <= limit && at_next.error < at.error) break;
      }
      if (!(factor > 1e-6)) break;  // no step gets closer: converged to rounding, or no solution
      plane[0] = next[0];
      plane[1] = next[1];
      at = at_next;
    }
    return at.determinant > 0 && at.error <= 8.0 * rounding && std::hypot(plane[0], plane[1]) <= limit;
  }

  /// Radius up to which the denominator is positive; may be infinite.
  static double pole_radius(const double* k) requires kHasDenominator {
    return radius_at(first_root(bernstein_to_infinity(denominator_in_squares(k))));
  }

  /// Radius up to which the radial profile r s(r) increases and its denominator is positive; may be infinite.
  static double max_radius(const double* k) {
    double root = first_root(bernstein_to_infinity(slope_in_squares(k)));  // in v = r² / (1 + r²)
    if constexpr (kHasDenominator) root = std::min(root, first_root(bernstein_to_infinity(denominator_in_squares(k))));
    return radius_at(root);
  }

  /// Whether the profile increases up to r²; quick, and false when that is not plain.
  static bool grows_up_to_square(const double* k, double r2) {
    if constexpr (kHasDenominator) {
      if (!all_positive(bernstein_to_limit(denominator_in_squares(k), r2))) return false;
    }
    return all_positive(bernstein_to_limit(slope_in_squares(k), r2));
  }

 private:
  static std::array<double, 4> denominator_in_squares(const double* k) requires kHasDenominator {
    return {1.0, k[5], k[6], k[7]};
  }

  /// The profile's slope in powers of r², times the denominator squared.
  static auto slope_in_squares(const double* k) {
    if constexpr (kHasDenominator) {
      const std::array<double, 4> above{1.0, k[0], k[1], k[4]};
      const std::array<double, 4> below = denominator_in_squares(k);
      std::array<double, 7> slope{};
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
          slope[i + j] += (1.0 + 2.0 * static_cast<double>(i) - 2.0 * static_cast<double>(j)) * above[i] * below[j];
        }
      }
      return slope;
    } else {
      return std::array<double, 4>{1.0, 3.0 * k[0], 5.0 * k[1], 7.0 * k3(k)};
    }
  }

  /// Of v = r² / (1 + r²).
  static double radius_at(double v) {
    return v < 1.0 ? std::sqrt(v / (1.0 - v)) : std::numeric_limits<double>::infinity();
  }

  template <typename T>
  static T k3(const T* k) {
    if constexpr (n >= 5) return k[4];
    return T(0);
  }

  template <typename T>
  static T numerator(const T* k, const T& r2) {
    if constexpr (n >= 5) return T(1) + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    return T(1) + r2 * (k[0] + r2 * k[1]);
  }

  template <typename T>
  static T denominator(const T* k, const T& r2) {
    if constexpr (kHasDenominator) return T(1) + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
    return T(1);
  }

  template <typename T>
  static T numerator_slope(const T* k, const T& r2) {
    return k[0] + r2 * (T(2) * k[1] + r2 * T(3) * k3(k));
  }

  template <typename T>
  static T denominator_slope(const T* k, const T& r2) {
    if constexpr (kHasDenominator) return k[5] + r2 * (T(2) * k[6] + r2 * T(3) * k[7]);
    return T(0);
  }

  /// Inverse of the radial profile; `limit`, kept just inside, for radii beyond the profile's top. The equation is
  /// solved without its denominator: near a pole the profile is so steep that Newton would stand still.
  static double radius_from_distorted(const double* k, double target, double limit) {
    const auto excess = [k, target](double r) {
      const double r2 = r * r;
      const double above = numerator(k, r2);
      const double slope = numerator_slope(k, r2);
      return ValueAndSlope{r * above - target * denominator(k, r2),
                           above + 2.0 * r2 * slope - 2.0 * r * target * denominator_slope(k, r2)};
    };
    double high = std::min(limit, std::max(2.0 * target, 1e-3));
    while (high < limit && high < 1e9 && excess(high).value < 0) high = std::min(limit, 2.0 * high);
    if (!(excess(high).value >= 0)) return 0.999 * high;
    return solve_increasing(excess, 0.0, 0.0, high, std::min(target, high));
  }

  struct Newton {
    double step[2];
    double error;
    double determinant;  ///< of the Jacobian; 0 outside of the domain
  };

  static Newton newton_at(const double* k, const double* plane, const double* distorted) {
    double now[2];
    double j[4];
    if (!distort<double>(k, plane, now, j, nullptr)) return {};
    const double dx = now[0] - distorted[0];
    const double dy = now[1] - distorted[1];
    const double determinant = j[0] * j[3] - j[1] * j[2];
    const double inverse = 1.0 / determinant;
    return {{inverse * (j[3] * dx - j[1] * dy), inverse * (j[0] * dy - j[2] * dx)}, std::hypot(dx, dy), determinant};
  }
};

/// A perspective camera behind a distorted plane: brown_conrady, rational and thin_prism differ only in n.
/// Rays with z <= 0 do not project.
template <int n>
struct DistortedPinhole {
  template <typename T>
  static bool plane_from_ray(const T* k, const T* ray, T* plane) {
    if (!(ray[2] > T(0))) return false;
    const T ideal[2] = {ray[0] / ray[2], ray[1] / ray[2]};
    return PlaneDistortion<n>::distort(k, ideal, plane);
  }

  template <typename T>
  static bool plane_from_ray(const T* k, const T* ray, T* plane, T* plane_wrt_ray, T* plane_wrt_k) {
    if (!(ray[2] > T(0))) return false;
    const T inverse_z = T(1) / ray[2];
    const T ideal[2] = {ray[0] * inverse_z, ray[1] * inverse_z};
    T wrt_ideal[4];
    if (!PlaneDistortion<n>::distort(k, ideal, plane, wrt_ideal, plane_wrt_k)) return false;
    for (int axis = 0; axis < 2; ++axis) {
      const T wrt_x = wrt_ideal[2 * axis] * inverse_z;
      const T wrt_y = wrt_ideal[2 * axis + 1] * inverse_z;
      plane_wrt_ray[3 * axis] = wrt_x;
      plane_wrt_ray[3 * axis + 1] = wrt_y;
      plane_wrt_ray[3 * axis + 2] = -(wrt_x * ideal[0] + wrt_y * ideal[1]);
    }
    return true;
  }

  static bool ray_from_plane(const double* k, const double* plane, double* ray) {
    double ideal[2];
    if (!PlaneDistortion<n>::undistort(k, plane, ideal)) return false;
    const double inverse_norm = 1.0 / std::sqrt(ideal[0] * ideal[0] + ideal[1] * ideal[1] + 1.0);
    ray[0] = ideal[0] * inverse_norm;
    ray[1] = ideal[1] * inverse_norm;
    ray[2] = inverse_norm;
    return true;
  }

  static double max_angle_rad(const double* k) { return std::atan(PlaneDistortion<n>::max_radius(k)); }

  static bool grows_up_to(const double* k, double angle) {
    const double r = std::tan(angle);
    return angle < M_PI_2 && PlaneDistortion<n>::grows_up_to_square(k, r * r);
  }
};

}  // namespace raybundle
