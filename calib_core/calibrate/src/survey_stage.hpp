// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// A rig with landmarks in its bundle: each image of them is one more frame, with one more rigid target.
struct SurveySolve {
  CalibrationProblem problem;  ///< corners' sigmas scaled to what their residuals show; landmarks behind all the boards
  BundleState state;
  BundleSummary summary;
  std::vector<SurveyImage> images;        ///< as they were placed before; fill_residuals() brings them up to date
  std::vector<Rigid3> target_from_local;  ///< of the targets that were added
  std::vector<std::string> not_placed;    ///< a sentence for each image that could not be
};

/// Places the images of the problem's survey by the calibrated cameras, leaves out sightings that contradict the
/// others, and solves for cameras, boards and the landmarks' images together.
///
/// A landmark that is wrong by its sigma is so in all its sightings; each of n has √n times the landmark's share of its
/// sigma, so that together they count for one.
///
/// @param known         covariance of the cameras
/// @param corner_scale  of the corners' residuals over their stated sigmas
SurveySolve solve_with_landmarks(const CalibrationProblem& problem, const BundleState& cameras, const Covariance& known,
                                 double corner_scale, const CalibrateOptions& options, const BundleOptions& bundle);

/// Poses and residuals of the landmarks' images, as the last solve has left them.
void fill_residuals(const CalibrationProblem& problem, const BundleState& state,
                    const std::vector<Rigid3>& target_from_local, std::vector<SurveyImage>& images);

/// Takes what the landmarks added off again.
///
/// @param targets  that were added, as many as frames
void leave_out_landmarks(std::size_t targets, CalibrationProblem& problem, BundleState& state);

/// Fills rms_px and variance_factor.
void sum_up(SurveyImage& image);

}  // namespace raybundle
