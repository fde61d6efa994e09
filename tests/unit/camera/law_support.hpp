// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "model_test_types.hpp"
#include "raybundle/camera/camera.hpp"

namespace raybundle {

/// Makes failure messages name the model.
struct ModelTestName {
  template <typename M>
  static std::string GetName(int) {
    return std::string(M::kName);
  }
};

inline Eigen::Vector3d ray_at(double angle_rad, double azimuth_rad) {
  return {std::sin(angle_rad) * std::cos(azimuth_rad), std::sin(angle_rad) * std::sin(azimuth_rad),
          std::cos(angle_rad)};
}

/// Unit rays up to an angle off the axis: the axis itself, its close neighbourhood, and random ones from a fixed seed.
inline std::vector<Eigen::Vector3d> rays_up_to(double half_angle_rad, int count = 300) {
  std::vector<Eigen::Vector3d> rays{ray_at(0, 0), ray_at(1e-13, 1), ray_at(1e-9, 2), ray_at(1e-5, 3),
                                    ray_at(half_angle_rad, 0.5)};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  while (static_cast<int>(rays.size()) < count) {
    rays.push_back(ray_at(half_angle_rad * unit(random), 2 * M_PI * unit(random)));
  }
  return rays;
}

template <CameraModel M>
Camera camera_with_shape(const double* shape) {
  Camera camera{*model_named(M::kName), {1280, 960}, Eigen::VectorXd(kParameterCount<M>)};
  camera.parameters.head<4>() << 417.0, 421.5, 633.2, 487.9;
  for (int k = 0; k < kShapeSize<M>; ++k) camera.parameters[4 + k] = shape[k];
  return camera;
}

}  // namespace raybundle
