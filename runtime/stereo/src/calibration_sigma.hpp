// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/stereo/rectification.hpp"

namespace raybundle {

/// What the uncertainty of a calibration does to points.
struct CalibrationSigma {
  double relative_baseline = 0.0;         ///< standard deviation of the baseline over the baseline
  std::vector<float> disparity_sigma_px;  ///< for each pixel of the rectified image, for points that are far away
};

/// Carries the joint covariance through the rectification, to first order: how the disparity that two fixed pixels seem
/// to have changes with each parameter. Zero for a calibration without covariance. Between the nodes of a grid the
/// standard deviation is interpolated.
CalibrationSigma calibration_sigma(const Covariance& covariance, const RigCamera& left, const RigCamera& right,
                                   const Rectification& pair);

}  // namespace raybundle
