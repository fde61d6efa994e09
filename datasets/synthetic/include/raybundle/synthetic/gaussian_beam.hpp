// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "raybundle/geometry/line.hpp"

namespace raybundle {

/// A beam in any frame: Gaussian across, wider away from its waist.
struct GaussianBeam {
  Line3 line;
  double power_W = 0.0;
  double waist_radius_m = 0.0;
  double waist_distance_m = 0.0;
  double divergence_rad = 0.0;

  /// 1/e² radius so far along the beam.
  double radius_m(double along_m) const;

  /// On a surface across the beam [W/m²].
  double irradiance_W_m2(const Eigen::Vector3d& place) const;
};

}  // namespace raybundle
