// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace raybundle {

/// The projection through a sphere (or, with beta, an ellipsoid) that unified, extended_unified and double_sphere have
/// in common:
///
///   plane = (x, y) / (a d + b z),   d = √(beta (x² + y²) + z²)
///
/// a = alpha, b = 1 - alpha in the two newer models; a = xi, b = 1 in Mei's. The model is one-to-one where
///   a d + b z > 0   (the point is in front of the projection centre) and
///   b d + a z > 0   (the radius still grows with the angle).
/// For 0 <= alpha <= 1 these two are the condition z > -w1 d of the papers, where w1 is the smaller of alpha / (1 -
/// alpha) and its inverse; written so, they also hold for alpha < 0, where a lens has pincushion distortion.
template <typename T>
struct UnifiedSphere {
  T a;
  T b;
  T beta;

  bool project(const T* point, T* plane) const {
    using std::sqrt;
    const T d = sqrt(beta * (point[0] * point[0] + point[1] * point[1]) + point[2] * point[2]);
    const T below = a * d + b * point[2];
    if (!(below > T(0)) || !(b * d + a * point[2] > T(0))) return false;
    plane[0] = point[0] / below;
    plane[1] = point[1] / below;
    return true;
  }

  /// The same with Jacobians.
  ///
  /// @param wrt_point  2×3 row-major
  /// @param wrt_a_b    2×2 row-major: a, b
  /// @param wrt_beta   2
  bool project(const T* point, T* plane, T* wrt_point, T* wrt_a_b, T* wrt_beta) const {
    using std::sqrt;
    const T r2 = point[0] * point[0] + point[1] * point[1];
    const T d = sqrt(beta * r2 + point[2] * point[2]);
    const T below = a * d + b * point[2];
    if (!(below > T(0)) || !(b * d + a * point[2] > T(0))) return false;
    const T inverse_below = T(1) / below;
    const T a_over_d = a / d;
    const T below_wrt_point[3] = {a_over_d * beta * point[0], a_over_d * beta * point[1], a_over_d * point[2] + b};
    for (int axis = 0; axis < 2; ++axis) {
      plane[axis] = point[axis] * inverse_below;
      const T minus = -plane[axis] * inverse_below;
      for (int i = 0; i < 3; ++i) wrt_point[3 * axis + i] = minus * below_wrt_point[i];
      wrt_point[3 * axis + axis] += inverse_below;
      wrt_a_b[2 * axis] = minus * d;
      wrt_a_b[2 * axis + 1] = minus * point[2];
      wrt_beta[axis] = minus * T(0.5) * a_over_d * r2;
    }
    return true;
  }

  /// A point (plane, z) that projects to `plane`; its length is arbitrary. False where there is none.
  bool unproject(const double* plane, double* point) const {
    if (!(a + b > 0) || !(beta > 0)) return false;
    const double r2 = beta * (plane[0] * plane[0] + plane[1] * plane[1]);
    const double root2 = 1.0 - (a - b) * (a + b) * r2;
    if (!(root2 >= 0)) return false;
    const double root = std::sqrt(root2);
    point[0] = plane[0];
    point[1] = plane[1];
    // the same root of (a² - b²) z² + 2 b z + a² r² - 1 = 0, written without cancellation for either sign
    point[2] = a >= 0 && b >= 0 ? (1.0 - a * a * r2) / (a * root + b) : (a * root - b) / ((a - b) * (a + b));
    return true;
  }

  /// Angle off the axis [rad] of `point` up to which the projection is one-to-one.
  double max_angle_rad() const {
    if (!(a + b > 0) || !(beta > 0)) return 0.0;
    double cosine = -1.0;
    if (b > 0) cosine = std::max(cosine, -a / b);
    if (a > 0) cosine = std::max(cosine, -b / a);
    return std::atan2(std::sqrt((1.0 - cosine) * (1.0 + cosine) / beta), cosine);
  }
};

}  // namespace raybundle
