// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// What each camera tells by itself, without a word of the others. Vectors are aligned with the problem's cameras and
/// views.
struct CamerasAlone {
  std::vector<std::optional<Camera>> cameras;        ///< empty where the views do not determine one
  std::vector<std::string> why_not;                  ///< for those
  std::vector<std::string> why_aside;                ///< for those: a clause for each of their views
  std::vector<double> sigmas;                        ///< of each camera's noise, as in robust_sigmas
  std::vector<BundleSummary> summaries;              ///< of the last solve of each camera
  std::vector<std::vector<ParameterRule>> given_up;  ///< of each camera: coefficients that are held at zero
  std::vector<ParameterRule> lens_priors;            ///< of all cameras
  std::vector<std::optional<Rigid3>> camera_from_target;
  std::vector<std::optional<Rigid3>> mirrored;  ///< camera_from_target that fits nearly as well, in a rig
  std::vector<std::vector<ObservationFate>> fates;
  std::vector<std::string> reasons;  ///< why a view has no pose
};

/// Calibrates every camera alone: start without a focal guess, robust solve, a second chance for the views that did not
/// fit, least squares without the outliers; of several starts the one that all corners fit best; then other optima and
/// the views that were lost. A camera that cannot be calibrated costs only itself. Cameras are calibrated side by side,
/// on the threads that there are.
///
/// @param problem  lends its views to the cameras, and has them all again in the end
/// @param stages   the times of `start` and `solve` are added
/// @throws Error when the only camera cannot be calibrated
CamerasAlone solve_cameras_alone(CalibrationProblem& problem, const CalibrateOptions& options,
                                 std::vector<StageTime>& stages);

}  // namespace raybundle
