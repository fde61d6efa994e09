// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/survey.hpp"

namespace raybundle {

/// What a landmark says of a calibration: where it was seen against where it should be.
struct LandmarkResidual {
  std::string landmark;
  Eigen::Vector2d pixel;        ///< as seen
  Eigen::Vector2d residual_px;  ///< seen minus predicted
  double range_m = 0.0;         ///< from the camera; infinite for directions
  double sigma_px = 0.0;        ///< of one coordinate: sighting, landmark and calibration together
  double sigmas = 0.0;          ///< length of the residual, whitened; about 1.2 in the median when all is as stated
  bool used = true;             ///< false: more than four sigmas off, and left out of the pose
};

/// One image of a survey: the camera's pose by its landmarks, all else held, and what is left.
struct SurveyImage {
  std::string image;
  Rigid3 camera_from_local;
  Eigen::Matrix<double, 6, 1> pose_sigma;  ///< as perturbed(): rotation [rad], translation [m]; NaN: not determined
  std::vector<LandmarkResidual> landmarks;
  double rms_px = 0.0;           ///< of those that were used
  double variance_factor = 1.0;  ///< chi² per degree of freedom: about 1 when all sigmas are as stated
};

/// Places a calibrated camera by surveyed landmarks, image by image, and tells how far off they are: a test of the
/// calibration in the far field, where no board goes.
///
/// Directions give the rotation; points, four or more of them, the position too. Each residual is weighed by the
/// sigmas of sighting and landmark; the calibration's own uncertainty at that pixel and range stands beside them.
///
/// @param sighting_sigma_px  of u and of v
/// @throws Error(kNotEnoughData) naming the image that shows too few landmarks or a camera that cannot see them
std::vector<SurveyImage> check_survey(const Calibration& calibration, const RigCamera& camera,
                                      const std::vector<Landmark>& landmarks, const std::vector<Sighting>& sightings,
                                      double sighting_sigma_px);

}  // namespace raybundle
