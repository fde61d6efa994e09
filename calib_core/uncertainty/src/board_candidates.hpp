// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "imagined_board.hpp"
#include "raybundle/uncertainty/coverage.hpp"

namespace raybundle {

/// A place in which a board can be held.
struct BoardCandidate {
  int camera = 0;  ///< index of the calibration
  Rigid3 rig_from_target;
  std::string text;  ///< how to hold it
};

/// Boards all over a camera's image, near and far, facing it and tilted towards four sides, of which the camera sees
/// at least half of the points.
///
/// @param imagined  the target
/// @param held      how far off it was seen
std::vector<BoardCandidate> board_candidates(const Calibration& calibration, int camera, int target,
                                             const ImaginedBoard& imagined, const CameraCoverage& held);

/// Edge of a board's points in a camera's image, point by point; empty when a part of it does not project.
std::vector<Eigen::Vector2d> outline_in_image(const RigCamera& camera, const Target& target,
                                              const Rigid3& rig_from_target);

}  // namespace raybundle
