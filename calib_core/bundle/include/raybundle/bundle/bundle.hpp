// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// The unknowns of the bundle.
struct BundleState {
  std::vector<Camera> cameras;          ///< aligned with problem.cameras
  std::vector<Rigid3> camera_from_rig;  ///< aligned with problem.cameras; the first is the identity and stays
  std::vector<BoardPose> poses;
  std::vector<BoardShape> shapes;  ///< aligned with problem.targets

  std::vector<int> pose_of_view;                    ///< aligned with problem.views; -1: the view is not used
  std::vector<std::vector<ObservationFate>> fates;  ///< aligned with problem.views and their observations

  /// By LaserGrid::index, in the rig frame; nothing for beams that no dot determines. Empty: the dots take no part.
  std::vector<std::optional<Line3>> beams = {};
  /// Aligned with problem.views and their dots, when there are beams.
  std::vector<std::vector<ObservationFate>> dot_fates = {};
};

/// What is known of a beam besides its dots: a normal distribution of motion_between(line, beam).
struct BeamPrior {
  Line3 line;
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
};

struct BundleOptions {
  bool estimate_shape = false;      ///< bend and twist of flat targets
  double robust_scale_sigma = 0.0;  ///< Cauchy loss beyond this many sigmas of a corner; 0: plain least squares
  std::vector<std::optional<BeamPrior>> beam_priors = {};  ///< aligned with BundleState::beams, or empty
  int max_iterations = 100;
  int threads = 1;  ///< changes the time, never the bits

  /// Relative decrease of the cost below which the solve is over. It is also over, near the optimum, when what is left
  /// moves no unknown by a thousandth of its sigma, as the residuals tell it: exact data give the exact answer.
  double settled = 1e-14;
};

struct BundleSummary {
  Termination termination = Termination::kFailed;
  int iterations = 0;
  double initial_cost = 0.0;  ///< half the (robustified) sum of squared whitened residuals
  double final_cost = 0.0;
  std::string message;
};

/// Marks every observation kUsed that the state's cameras project, kUnprojectable otherwise, kViewSetAside for unused
/// views; observations already marked kOutlier stay so.
void mark_projectable(const CalibrationProblem& problem, BundleState& state);

/// Marks every dot whose beam the state holds kUsed when its prediction exists, kUnprojectable otherwise; kUnlabelled
/// and kViewSetAside as their names say; dots already marked kOutlier stay so.
void mark_dots(const CalibrationProblem& problem, BundleState& state);

/// Minimises the whitened reprojection error of corners and dots over everything that problem.rules leaves free, the
/// board poses and the beams, in place. Only observations and dots marked kUsed take part.
BundleSummary solve_bundle(const CalibrationProblem& problem, BundleState& state, const BundleOptions& options = {});

/// Measured minus projected [px] of all observations of one view, NaN where the model does not project.
std::vector<Eigen::Vector2d> view_residuals(const CalibrationProblem& problem, const BundleState& state, int view);

/// view_residuals of each view of the problem; those of views without a pose are NaN.
std::vector<std::vector<Eigen::Vector2d>> all_residuals(const CalibrationProblem& problem, const BundleState& state);

/// Measured minus predicted [px] of all dots of one view, NaN where there is no prediction: the dot's beam is unknown,
/// misses the board's surface, or meets it where the camera model does not project.
std::vector<Eigen::Vector2d> dot_residuals(const CalibrationProblem& problem, const BundleState& state, int view);

/// camera_from_target of a used view: camera_from_rig * rig_from_target.
Rigid3 camera_from_target(const CalibrationProblem& problem, const BundleState& state, int view);

}  // namespace raybundle
