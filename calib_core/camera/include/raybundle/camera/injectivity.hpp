// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "raybundle/camera/camera.hpp"

namespace raybundle {

/// Does a camera's projection stay one-to-one over its whole image?
struct InjectivityReport {
  double covered_fraction = 0.0;           ///< of the image: pixels with exactly one ray
  double nearest_border_angle_rad = 0.0;   ///< smallest angle off the axis among covered pixels of the border; 0: none
  double farthest_border_angle_rad = 0.0;  ///< largest of them
  double max_angle_rad = 0.0;              ///< where the radial profile ends or folds
  std::optional<Eigen::Vector2d> first_offender;  ///< pixel without exactly one ray, nearest to the principal point
  double first_offender_radius_px = 0.0;          ///< its distance from the principal point [px]

  bool one_to_one() const { return !first_offender; }
};

/// Tests a grid of pixels, borders included: each must have a ray whose projection is that pixel again, with a positive
/// Jacobian determinant.
///
/// @param samples_per_side  grid points along each side, at least 2
/// @throws Error(kBadInput) when the camera's image is empty or its parameters do not fit the model
InjectivityReport check_injectivity(const Camera& camera, int samples_per_side = 65);

}  // namespace raybundle
