// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/survey.hpp"

namespace raybundle {

/// Images of a survey, placed one by one: one that cannot be costs the others nothing.
struct PlacedImages {
  std::vector<SurveyImage> images;
  std::vector<std::string> not_placed;  ///< why, a sentence for each of the others
};

/// Places a calibrated camera by surveyed landmarks, image by image, and tells how far off they are: a test of the
/// calibration in the far field, where no board goes.
///
/// Directions give the rotation; points, four or more of them, the position too. Each residual is weighed by the
/// sigmas of sighting, landmark and, at that pixel and range, of the calibration itself.
///
/// @param survey  its sightings by other cameras are passed over
/// @throws Error(kBadInput) naming a sighting outside of the image
/// @throws Error(kNotEnoughData) when the camera saw none of them
PlacedImages check_survey(const Calibration& calibration, const RigCamera& camera, const Survey& survey);

}  // namespace raybundle
