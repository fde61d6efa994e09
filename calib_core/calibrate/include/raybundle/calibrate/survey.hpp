// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/survey.hpp"

namespace raybundle {

/// Places a calibrated camera by surveyed landmarks, image by image, and tells how far off they are: a test of the
/// calibration in the far field, where no board goes.
///
/// Directions give the rotation; points, four or more of them, the position too. Each residual is weighed by the
/// sigmas of sighting, landmark and, at that pixel and range, of the calibration itself.
///
/// @param survey  its sightings by other cameras are passed over
/// @throws Error(kBadInput) naming a sighting outside of the image
/// @throws Error(kNotEnoughData) naming the image that shows too few landmarks or a camera that cannot see them
std::vector<SurveyImage> check_survey(const Calibration& calibration, const RigCamera& camera, const Survey& survey);

}  // namespace raybundle
