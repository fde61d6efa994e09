// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "raybundle/scene/laser.hpp"

namespace raybundle {

/// Where a board point was measured in an image.
struct Observation {
  // 32 bytes in this order, 48 with the id first.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< [px], (0, 0) is the centre of the top-left pixel
  double sigma_px = 1.0;                            ///< standard deviation of each coordinate, > 0
  int point_id = 0;
};

/// What one camera saw of one board in one frame. Indices refer to the CalibrationProblem.
struct TargetView {
  int camera = 0;
  int frame = 0;
  int target = 0;
  std::vector<Observation> observations;  ///< point ids do not repeat
  std::string image = {};                 ///< path of the image, may be empty
  std::vector<Dot> dots = {};             ///< laser dots on this board; of one beam at most one
};

}  // namespace raybundle
