// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "raybundle/camera/camera_model.hpp"

namespace raybundle {

/// The perspective camera: plane = (x/z, y/z). Rays with z <= 0 do not project.
struct Pinhole {
  static constexpr std::string_view kName = "pinhole";
  static constexpr std::array<std::string_view, 0> kShapeNames{};
  static constexpr std::array<double, 0> kStartShape{};
  static constexpr std::array kExamples{ExampleShape<0>{{}, 1.2}};
  static constexpr std::array kForeignNames{
      ForeignName{"opencv", "plumb_bob"},    ForeignName{"mrcal", "LENSMODEL_PINHOLE"},
      ForeignName{"kalibr", "pinhole-none"}, ForeignName{"ros", "plumb_bob"},
      ForeignName{"colmap", "PINHOLE"},      ForeignName{"basalt", "pinhole"}};

  template <typename T>
  static bool plane_from_ray(const T*, const T* ray, T* plane) {
    if (!(ray[2] > T(0))) return false;
    plane[0] = ray[0] / ray[2];
    plane[1] = ray[1] / ray[2];
    return true;
  }

  template <typename T>
  static bool plane_from_ray(const T* shape, const T* ray, T* plane, T* plane_wrt_ray, T*) {
    if (!plane_from_ray(shape, ray, plane)) return false;
    const T inverse_z = T(1) / ray[2];
    plane_wrt_ray[0] = inverse_z;
    plane_wrt_ray[1] = T(0);
    plane_wrt_ray[2] = -plane[0] * inverse_z;
    plane_wrt_ray[3] = T(0);
    plane_wrt_ray[4] = inverse_z;
    plane_wrt_ray[5] = -plane[1] * inverse_z;
    return true;
  }

  static bool ray_from_plane(const double*, const double* plane, double* ray) {
    const double inverse_norm = 1.0 / std::sqrt(plane[0] * plane[0] + plane[1] * plane[1] + 1.0);
    ray[0] = plane[0] * inverse_norm;
    ray[1] = plane[1] * inverse_norm;
    ray[2] = inverse_norm;
    return true;
  }

  static double max_angle_rad(const double*) { return M_PI_2; }
};
static_assert(CameraModel<Pinhole>);

}  // namespace raybundle
