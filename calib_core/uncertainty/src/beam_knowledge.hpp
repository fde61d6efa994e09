// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// One matrix for each of LaserPattern::beams.
using BeamMatrices = std::vector<Eigen::Matrix4d>;

/// Covariances of the beams as the calibration states them.
BeamMatrices stated_beams(const Calibration& calibration);

/// Of a dot as the solve found it: the stated sigma, and how far residuals exceed such ones; zero without dots.
double dot_sigma(const CalibrationProblem& problem, const CalibrationResult& result);

/// What a board in a place would tell about each beam whose dot on it the first camera would see, cameras and board
/// being known; zero for the others.
BeamMatrices imagined_dots(const Calibration& calibration, int target, const Rigid3& rig_from_target, double sigma_px);

/// Sigmas [m] of the beams' depths at a range when their covariances have become these. What the cameras add to the
/// stated ones stays. Beams whose depth is not stated there are left out.
std::vector<double> beam_sigmas(const Calibration& calibration, const BeamMatrices& covariances, double range_m);

}  // namespace raybundle
