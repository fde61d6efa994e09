// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// A laser dot on a board whose place is known from its corners, as a calibration explains it.
struct HeldOutDot {
  int view = 0;
  int dot = 0;  ///< of the view
  int beam = 0;
  Eigen::Vector2d residual_px;  ///< measured minus where the beam meets the board
  double depth_m = 0.0;         ///< of the dot by camera ray and beam, along z of its camera
  double off_board_m = 0.0;     ///< of that point from the board's surface, towards the camera positive
};

/// The point of a beam that a pixel is nearest to in the image, in the rig frame; nothing where there is none before
/// the camera.
///
/// @param start_m  range along the beam from line.point, near the answer
std::optional<Eigen::Vector3d> point_on_beam(const RigCamera& camera, const Line3& line, const Eigen::Vector2d& pixel,
                                             double start_m);

/// Dots by the beam that is predicted nearest to them, if none other is as near and it is within the tolerance. Their
/// labels are not used.
///
/// @param rig_from_target  aligned with problem.views; empty: the board's place is not known
std::vector<HeldOutDot> explain_dots(const Calibration& calibration, const CalibrationProblem& problem,
                                     const std::vector<std::optional<Rigid3>>& rig_from_target, double tolerance_px);

/// What can be asked of the dots of one view.
struct DotsOnBoard {
  int dots = 0;   ///< that the camera sees amid the board's points
  int beams = 0;  ///< that meet the board there, in sight of the camera

  int to_explain() const { return dots < beams ? dots : beams; }  ///< at the most: beams may be unknown, dots on ink
};

/// How many dots of each view beams should explain; none where the board's place is not known or the board is not flat.
///
/// @return  aligned with problem.views
std::vector<DotsOnBoard> dots_on_boards(const Calibration& calibration, const CalibrationProblem& problem,
                                        const std::vector<std::optional<Rigid3>>& rig_from_target);

}  // namespace raybundle
