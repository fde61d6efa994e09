// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/bundle/view_block.hpp"
#include "raybundle/scene/board_surface.hpp"

namespace raybundle {

/// A dot as the bundle needs it.
struct UsedDot {
  Eigen::Vector2d pixel;      ///< measured [px]
  Eigen::Vector3d whitening;  ///< (0,0), (1,0), (1,1) of the inverse of the covariance's Cholesky factor [1/px]
  int beam = 0;               ///< index into BundleState::beams
  int pose_beam = 0;          ///< index into BlockSystem::pose_beams of its pose and beam
};

/// The used dots of one board view, gathered once.
struct ViewDots {
  int view = 0;  ///< index into problem.views
  int camera = 0;
  int target = 0;
  int pose = 0;
  ModelId model;
  BoardSurface surface;
  std::vector<UsedDot> dots;
};

/// One entry for each view that has a pose and at least one used dot, in the order of problem.views; `pose_beam` is not set.
///
/// @throws Error(kBadInput) for used dots on a target that is not flat
std::vector<ViewDots> used_dots(const CalibrationProblem& problem, const BundleState& state);

/// Whether a dot takes part: it is marked used, and the state holds its beam.
bool in_use(const CalibrationProblem& problem, const BundleState& state, int view, int dot);

/// What the motion of a dot's beam and of its board do to the dot; a board moves the dot along the beam only.
///
/// With the offsets a and the slopes s of the beam's motion the whitened residual changes by
/// across · (a + distance s), and with the motion w of rig_from_target by along_beam · (by_board · w).
struct DotMotion {
  Eigen::Matrix2d across;
  double distance = 0.0;  ///< of the dot from the beam's point, along the beam [m]
  Eigen::Vector2d along_beam;
  Eigen::Matrix<double, 6, 1> by_board;
};

/// The whitened residuals (predicted minus measured) of a view's dots, two rows for each, and their derivatives,
/// weighted as the rows of ViewBlock are.
///
/// Columns: intrinsics, motion of rig_from_target, [bend_x, bend_y, twist,] residual, [motion of camera_from_rig].
struct DotRows {
  Eigen::MatrixXd rows;  ///< padded with zero rows for gram()
  std::vector<DotMotion> motions;
  int intrinsics = 0;        ///< columns of
  double robust_chi2 = 0.0;  ///< sum of ρ(s) over the dots, s the squared whitened distance

  int residual_column(bool with_shape) const { return intrinsics + 6 + (with_shape ? 3 : 0); }
};

struct DotRowsOptions {
  bool with_shape = false;
  bool with_camera = false;  ///< columns of camera_from_rig
  double robust_scale_sigma = 0.0;
};

/// False when a beam misses the board's surface or a dot is not projected; `rows` is then not meaningful.
///
/// @param beams  by UsedDot::beam
bool fill_dot_rows(const ViewDots& view, const ViewPoint& point, const std::vector<Line3>& beams,
                   const DotRowsOptions& options, DotRows& rows);

}  // namespace raybundle
