// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "robust_solve.hpp"

namespace raybundle {

/// Where a camera alone has come to.
struct CameraOptimum {
  SolvedState solved;
  /// projection_sigma_px() of the state, or more where lenses that fit as well project otherwise; NaN when the solve
  /// failed.
  double projection_sigma_px = 0.0;
  /// What mirrored_boards() gives, where the way here has told it.
  std::optional<std::vector<std::optional<Rigid3>>> mirrored = {};
};

/// Leaves the optima of a solved camera that lie beside the right one: boards held by their mirrored pose, lenses whose
/// model has a twin that fits better, or that fits better when it is grown from a simple shape, views that were lost,
/// and wrong corners among few. The state changes only to one of lower cost or, where other corners take part, that all
/// corners fit better or more of them take part in.
///
/// @param single  a problem with one camera
/// @return        `solved` where nothing was better
CameraOptimum leave_local_optima(const CalibrationProblem& single, const CalibrateOptions& options, SolvedState solved);

/// Whether the projection is known no better than to 0.3 thousandths of the image.
bool knows_loosely(const CameraOptimum& optimum);

/// Rays of corners in use, spread over the views, through the solved camera: some hundreds of them.
std::vector<Eigen::Vector3d> rays_seen(const CalibrationProblem& single, const BundleState& state);

/// The poses from which the boards look nearly the same to their camera; other cameras of a rig may know better.
///
/// @param single   a problem with one camera
/// @param optimum  of leave_local_optima()
/// @return         aligned with problem.views; empty where the pixels tell
std::vector<std::optional<Rigid3>> mirrored_boards(const CalibrationProblem& single, const CameraOptimum& optimum,
                                                   int threads);

}  // namespace raybundle
