// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "detect_images.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle::apps {

/// Adds corners that the detector missed, refined near where a calibration predicts them; boards at the rim count then,
/// and boards that were found by another camera of the frame only. Source of the idea: Duisterhof et al., "TartanCalib:
/// Iterative Wide-Angle Lens Calibration using Adaptive SubPixel Refinement of AprilTags", 2022.
///
/// @param result  of images.observations.problem as it is
/// @return        how many corners were added to images.observations.problem
int add_predicted_corners(const Dataset& dataset, const CalibrationResult& result, DetectedImages& images,
                          const DetectOptions& options);

}  // namespace raybundle::apps
