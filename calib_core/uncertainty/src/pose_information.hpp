// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/view_block.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// Normal equations, for the parameters that a covariance names, of views that share one board pose, when the pose may
/// follow freely.
struct PoseInformation {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

/// @param views  ViewData::camera and ::target are indices of the calibration; empty when a corner does not project
PoseInformation pose_information(const Calibration& calibration, const std::vector<ViewData>& views,
                                 const Rigid3& rig_from_target);

/// The corners of a view that a solve used, with the labels that it settled on.
///
/// @param camera  index of the view's camera in the calibration
ViewData used_corners(const CalibrationProblem& problem, const CalibrationResult& result, int view, int camera);

/// What a camera would see of a board: the points within its image; no rows when there are none.
ViewData imagined_corners(const Calibration& calibration, int camera, int target, const Rigid3& rig_from_target,
                          double sigma_px);

}  // namespace raybundle
