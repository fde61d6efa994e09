// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// One pose of one board; the cameras that saw it together share it.
struct BoardPose {
  int frame = 0;
  int target = 0;
  Rigid3 rig_from_target;
};

/// What became of one observation.
enum class ObservationFate : unsigned char {
  kUsed,
  kOutlier,        ///< left out by the outlier rule
  kUnprojectable,  ///< the model does not project it
  kViewSetAside,   ///< its view was not used
  kUnlabelled,     ///< a dot of which it is not known which beam made it
};

/// What became of one view; vectors are aligned with TargetView::observations.
struct ViewResult {
  int pose = -1;      ///< index into CalibrationResult::poses; -1 when set aside
  int symmetry = -1;  ///< of Target::symmetries, by which the solve relabelled the view; -1: none
  std::vector<Eigen::Vector2d> residuals_px;  ///< measured minus projected; NaN where there is none
  std::vector<ObservationFate> fates;
  double rms_px = 0.0;  ///< of the used observations: root of the mean squared distance
};

/// A view, or the tie between the cameras of a frame, that was not used, and why.
struct SetAside {
  enum class Scope { kView, kExtrinsics };  ///< kExtrinsics: the view is used, with a board pose of its own
  int view = 0;                             ///< index into CalibrationProblem::views
  Scope scope = Scope::kView;
  std::string reason;  ///< one clause: what was seen, in numbers
};

/// How one camera fared over its used observations.
struct CameraSummary {
  double rms_px = 0.0;     ///< root of the mean squared distance (OpenCV's definition)
  double median_px = 0.0;  ///< of the distances
  int views_used = 0;
  int views_total = 0;
  int corners_used = 0;
  int corners_outlier = 0;
};

enum class Termination { kConverged, kIterationLimit, kFailed };

/// Seconds that a stage of the work took.
struct StageTime {
  std::string name;
  double seconds = 0.0;
};

/// Everything a solve can be audited by.
struct CalibrationResult {
  Calibration calibration;
  std::vector<BoardPose> poses;
  std::vector<ViewResult> views;       ///< aligned with CalibrationProblem::views
  std::vector<CameraSummary> cameras;  ///< aligned with CalibrationProblem::cameras
  std::vector<SetAside> set_aside;
  double rms_px = 0.0;           ///< over all cameras
  double variance_factor = 1.0;  ///< chi² per degree of freedom; the covariance has been multiplied by it
  Termination termination = Termination::kFailed;
  int iterations = 0;
  std::string gauge;  ///< what fixes the frame and the scale, in words
  std::string outlier_rule;
  std::vector<std::string> warnings;
  std::vector<StageTime> stages;
};

}  // namespace raybundle
