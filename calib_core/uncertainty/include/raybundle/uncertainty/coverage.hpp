// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// "the top left corner", "the left edge", "the middle": the ninth of an image in which a pixel lies.
std::string region_in_words(ImageSize size, const Eigen::Vector2d& pixel);

/// Several of them as a list of words, in which all four corners and all four edges are named together.
std::string regions_in_words(std::vector<std::string> regions);

/// How one camera saw its boards.
struct CameraCoverage {
  std::string camera;
  double image_share = 0.0;                ///< of the cells of its CornerEvidence in which corners were used
  std::vector<std::string> empty_regions;  ///< ninths of the image of which less than a quarter is covered, in words
  double rayless_share = 0.0;              ///< of a grid over the image, where the lens has no ray
  double seen_to_rad = 0.0;                ///< angle off the axis of the farthest used corner
  double reach_rad = 0.0;                  ///< largest angle off the axis in the middle of an edge of the image
  double nearest_m = 0.0;                  ///< distance of the boards' centres, the 5 % quantile
  double farthest_m = 0.0;                 ///< the 95 % quantile
  double usual_tilt_rad = 0.0;             ///< of the boards against the line of sight, median
  double largest_tilt_rad = 0.0;           ///< the 90 % quantile
};

/// How far off and how tilted a camera's boards were held: of its coverage only that.
CameraCoverage held_boards(const CalibrationProblem& problem, const CalibrationResult& result, const RigCamera& camera);

/// One for each camera of the calibration, in its order.
std::vector<CameraCoverage> coverage(const CalibrationProblem& problem, const CalibrationResult& result);

}  // namespace raybundle
