// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/initialize/camera_start.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

constexpr double kSmallestSigma_px = 1e-4;  ///< exact data: rounding is not to be mistaken for outliers

/// A problem with some of the cameras of another one.
struct Subproblem {
  CalibrationProblem problem;
  std::vector<int> views;  ///< index in the whole problem of each view
};

/// Whether a rule keeps a camera's place at what says nothing in another frame than that of the first camera: at a value,
/// or at a start that cannot be expressed there.
///
/// @param new_frame_known  the place of the camera whose frame it will be
bool bound_to_frame(const ParameterRule& rule, bool new_frame_known);

/// The problem of some cameras alone, with the rules that speak of them.
///
/// @param cameras  indices in ascending order; the first one's frame becomes the rig frame: without camera 0 the rules
///                 that are bound to its frame are left out
Subproblem select_cameras(const CalibrationProblem& whole, const std::vector<int>& cameras);

/// The same with the views taken out of the whole problem, so that no corner is held twice: of what is left of them
/// only camera, frame and target may be asked.
Subproblem take_cameras(CalibrationProblem& whole, const std::vector<int>& cameras);

/// The problem with the state's intrinsics, which are not to move.
CalibrationProblem with_fixed_intrinsics(const CalibrationProblem& problem, const BundleState& state);

/// Puts right the point ids of mislabelled views of symmetric boards.
///
/// @param symmetry_of_view  as in RigStart
void relabel(CalibrationProblem& problem, const std::vector<int>& symmetry_of_view);

/// Multiplies the sigma of every corner, and of every prior that a rule gives, so that it weighs against them as before; exact data keep
/// one that rounding does not exceed.
void scale_corners(CalibrationProblem& problem, double scale);

/// The state with every so many boards only, with all views of them, so that it has about so many corners.
BundleState with_fewer_views(const BundleState& state, std::size_t corners);

/// Start state of a problem with one camera.
BundleState state_from_start(const CalibrationProblem& single, const CameraStart& start);

}  // namespace raybundle
