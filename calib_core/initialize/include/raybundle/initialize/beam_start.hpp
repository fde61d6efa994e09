// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// Cameras and boards, calibrated without the laser; the dots of a CalibrationProblem are seen against them.
struct LaserScene {
  const CalibrationProblem& problem;
  std::vector<Camera> cameras;                         ///< aligned with problem.cameras
  std::vector<Rigid3> camera_from_rig;                 ///< aligned with problem.cameras
  std::vector<std::optional<Rigid3>> rig_from_target;  ///< aligned with problem.views; empty: view not used
  std::vector<BoardShape> shapes;                      ///< aligned with problem.targets
};

/// Which beam made each dot, and where the beams are: good enough for the bundle to converge from.
struct BeamStart {
  std::vector<std::vector<int>> beam_of_dot;  ///< aligned with problem.views and their dots; or kUnlabelled
  std::vector<std::vector<bool>> on_board;    ///< aligned with the same: whether the dot lies on its board
  std::vector<std::optional<Line3>> lines;    ///< by beam: in the rig frame, pointing away from the projector
  std::optional<Grating> grating;             ///< common model of the lines, when they follow one
  double grating_rms_rad = 0.0;               ///< angle between the lines and the model's, root mean square
  double zero_order_row = 0.0;                ///< as LaserPattern
  double zero_order_column = 0.0;
  std::string origin;           ///< what fixed the origin of the labels, in words
  bool origin_guessed = false;  ///< nothing fixed it: all labels may be off by the same rows and columns
};

/// Labels dots without any guess of the projector, and fits a line to the dots of each beam: dots of one beam in many
/// board poses lie on one line, the lines' directions form a lattice, and the anchor, the brightest or the missing
/// beams, or the outermost rows and columns fix its origin. Labels that dots already have are kept. Dots that lie
/// beside their board stay unlabelled.
///
/// Columns count along the image's x of the first camera, rows along y, as near as the lattice's own steps come to it.
///
/// @throws Error(kNotEnoughData) when too few dots in too few poses line up, or when the lattice does not fit into
///         the grid; Error(kBadInput) when the anchor is not near a labelled dot; the message says which
BeamStart initialize_beams(const LaserScene& scene);

}  // namespace raybundle
