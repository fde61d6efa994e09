// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
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

  std::vector<int> beam_of_dot;  ///< aligned with TargetView::dots: the label, or kUnlabelled; as are the next two
  std::vector<Eigen::Vector2d> dot_residuals_px;  ///< measured minus predicted; NaN where there is none
  std::vector<ObservationFate> dot_fates;
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
  double sigma_scale = 1.0;  ///< that the sigmas of its corners were multiplied by: its noise against the others'
};

/// A camera's parameter without and with further measurements in the solve: a laser's dots, or landmarks.
struct DraggedParameter {
  std::string name;
  double without = 0.0;
  double with = 0.0;
  double sigma_without = 0.0;

  double moved_sigmas() const;  ///< 0 for a parameter that was not estimated
};

/// Largest move of a parameter, in its sigmas without the further measurements. More information moves an estimate by
/// less than its sigma; beyond 4 they contradict the corners.
double drag_sigmas(const std::vector<DraggedParameter>& parameters);

/// How the dots of a laser fared, and what they did to the cameras.
struct LaserSummary {
  int dots_used = 0;
  int dots_outlier = 0;
  int dots_unlabelled = 0;
  int dots_unused = 0;           ///< in views that were set aside, or of beams that too few dots determine
  double rms_px = 0.0;           ///< of the used dots: root of the mean squared distance
  double sigma_scale = 1.0;      ///< robust size of the dots' residuals over their stated sigmas
  double grating_rms_rad = 0.0;  ///< angle between the beams and the grating's common model, root mean square
  int beams_with_prior = 0;     ///< that the grating's model had to support: fewer than 3 hits, or less than 0.1 m deep
  std::string label_origin;     ///< what fixed the origin of the labels, in words
  bool origin_guessed = false;  ///< nothing did: all labels may be off by the same rows and columns
  std::vector<DraggedParameter> parameters;  ///< of the cameras, those that are free
};

/// How the landmarks fared that took part in the bundle, and what they did to the cameras.
struct SurveySummary {
  std::vector<SurveyImage> images;  ///< those that were placed
  std::vector<DraggedParameter> parameters;
};

/// How a solve ended. kBlocked: before the optimum, as each step to it would take corners or dots to where their camera's
/// model does not project.
enum class Termination { kConverged, kIterationLimit, kBlocked, kFailed };

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
  std::optional<LaserSummary> laser;    ///< of a problem with dots
  std::optional<SurveySummary> survey;  ///< of a problem with landmarks
  double rms_px = 0.0;                  ///< over all cameras
  double variance_factor = 1.0;         ///< chi² per degree of freedom; the covariance has been multiplied by it
  Termination termination = Termination::kFailed;
  int iterations = 0;
  std::vector<ParameterRule> lens_priors;  ///< that the solve took for granted, as CalibrationProblem::lens_priors
  std::string gauge;                       ///< what fixes the frame and the scale, in words
  std::string outlier_rule;
  std::vector<std::string> warnings;
  std::string scatter_warning;  ///< the one of them that says that frames scatter, which figures allow for; or empty
  std::vector<StageTime> stages;
};

}  // namespace raybundle
