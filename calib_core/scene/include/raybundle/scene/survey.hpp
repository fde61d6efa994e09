// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"

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
  std::string image;     ///< or the moment, for cameras that expose together
  std::string landmark;  ///< its name
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  std::string camera = {};  ///< its name; empty where there is no choice
};

/// Landmarks and where they were seen.
struct Survey {
  std::vector<Landmark> landmarks;
  std::vector<Sighting> sightings;
  double sighting_sigma_px = 0.5;  ///< of u and of v
};

/// What a landmark says of a calibration: where it was seen against where it should be.
struct LandmarkResidual {
  std::string landmark;
  Eigen::Vector2d pixel;        ///< as seen
  Eigen::Vector2d residual_px;  ///< seen minus predicted
  double range_m = 0.0;         ///< from the camera; infinite for directions
  double own_sigma_px = 0.0;    ///< of one coordinate: sighting and landmark
  double sigma_px = 0.0;        ///< the same with the calibration's, where that is not estimated with them
  double sigmas = 0.0;          ///< length of the residual, whitened; about 1.2 in the median when all is as stated
  bool used = true;             ///< false: more than four sigmas off, and left out of the pose
};

/// What one camera saw of a survey in one image.
struct SurveyImage {
  std::string image;
  std::string camera;
  Rigid3 camera_from_local;
  Eigen::Matrix<double, 6, 1> pose_sigma;  ///< of placing it with the calibration held, as perturbed(): rotation [rad],
                                           ///< translation [m]; NaN: not determined
  std::vector<LandmarkResidual> landmarks;
  double rms_px = 0.0;           ///< of those that were used
  double variance_factor = 1.0;  ///< chi² per degree of freedom: about 1 when all sigmas are as stated
};

}  // namespace raybundle
