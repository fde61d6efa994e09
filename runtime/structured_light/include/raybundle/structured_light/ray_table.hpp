// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/camera/camera.hpp"

namespace raybundle {

/// The rays of a camera as a grid of nodes, `step_px` apart from pixel (0, 0) on: what a device needs of a lens model,
/// whichever it is. Between nodes the rays are interpolated with cubics.
struct RayTable {
  /// A unit ray in the camera's frame and how it turns with the pixel [1/px]. NaN where the table has no ray.
  struct Ray {
    Eigen::Vector3d direction;
    Eigen::Matrix<double, 3, 2> per_px;
  };

  ImageSize size;
  double step_px = 0.0;
  int columns = 0;            ///< of nodes, at least 4
  int rows = 0;               ///< at least 4
  std::vector<double> nodes;  ///< x, y, z of each, row by row; NaN where the lens sees nothing
  double error_rad = 0.0;     ///< no ray of the table is farther off the lens model's

  /// The ray of a pixel of the image. NaN within two nodes of where the lens sees nothing.
  Ray at(const Eigen::Vector2d& pixel) const;
};

/// How many nodes of this step cover that many pixels.
int nodes_over(int pixels, double step_px);

/// The coarsest table whose rays are within 2 µrad of the camera's, by trial.
///
/// @throws Error(kBadInput) when the finest table errs by more than 100 µrad: such a lens is none that was calibrated
RayTable ray_table(const Camera& camera);

}  // namespace raybundle
