// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace raybundle {

/// A surveyed point, or a direction, in the local frame of the survey (east, north, up).
struct Landmark {
  std::string name;
  Eigen::Vector3d x_in_local = Eigen::Vector3d::Zero();  ///< [m]; a unit vector when it is infinitely far
  bool infinitely_far = false;
  double sigma = 0.0;  ///< of each coordinate [m], of a direction [rad]
};

/// Where a landmark was seen.
struct Sighting {
  std::string image;
  std::string landmark;  ///< its name
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

}  // namespace raybundle
