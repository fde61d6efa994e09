// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dataset.hpp"
#include "detect_images.hpp"

namespace raybundle::apps {

/// Finds the dots of the data set's laser in the images with the laser on, on the boards that were found with it off:
/// within the outline of the corners that were seen, so that nothing beside the board is taken for a dot on it.
///
/// @param images  of the same data set; its problem gets the laser, its views their dots, its hints what was odd
/// @throws Error(kNotEnoughData) when no view has both a board and an image with the laser on
void add_dots(const Dataset& dataset, const DetectOptions& options, DetectedImages& images);

/// Fixes the origin of the labels by one dot.
///
/// @throws Error(kBadInput) when there is no laser, no such view, or no such beam
void set_anchor(const DatasetAnchor& anchor, CalibrationProblem& problem);

}  // namespace raybundle::apps
