// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/view_block.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// Whitened rows [J r] of the corners of views that share one board pose, two after each other for each, by the
/// parameters that the calibration's covariance names, when the pose may follow freely: what is orthogonal to the
/// pose's columns. Zero when a corner does not project.
///
/// @param views  ViewData::camera and ::target are indices of the calibration
Eigen::MatrixXd rows_beside_pose(const Calibration& calibration, const std::vector<ViewData>& views,
                                 const Rigid3& rig_from_target);

/// The corners of a view that a solve used, with the labels that it settled on and the sigmas that it weighed them by.
///
/// @param camera  index of the view's camera in the calibration
ViewData used_corners(const CalibrationProblem& problem, const CalibrationResult& result, int view, int camera);

}  // namespace raybundle
