// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/information.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// A rig whose laser takes part in the bundle.
struct LaserSolve {
  CalibrationProblem problem;  ///< dots labelled; sigmas of corners and dots scaled to what their residuals show
  BundleState state;
  BundleOptions bundle;  ///< with the priors of weak beams
  BundleSummary summary;
  LaserPattern pattern;  ///< beams without their covariances
  LaserSummary laser;
  std::vector<std::vector<bool>> on_board;  ///< aligned with problem.views and their dots
};

bool has_dots(const CalibrationProblem& problem);

/// Labels the dots of a calibrated rig without any guess of the projector, and solves for cameras, boards and beams
/// together. Corners and dots are weighed by their own residuals, so that neither kind drags the other by claiming too
/// much.
///
/// @param corner_scale  of the corners' residuals over their stated sigmas
/// @throws Error(kNotEnoughData) when the dots do not determine the beams
LaserSolve solve_with_dots(const CalibrationProblem& problem, const BundleState& cameras, double corner_scale,
                           const CalibrateOptions& options, const BundleOptions& bundle);

/// Fills in the beams' covariances, the uncertainty of depth, and the advice for labelling.
///
/// @param parameters       covariance of the cameras of the joint solve
/// @param variance_factor  that its parts have been multiplied by
void fill_uncertainty(const LaserSolve& solve, const Covariance& parameters, double variance_factor,
                      const RigCamera& first_camera, LaserPattern& pattern);

}  // namespace raybundle
