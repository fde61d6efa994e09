// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// A view's board pose as the rig start sees it: all candidates, and how far they can be trusted.
struct PosedView {
  int view = 0;
  int camera = 0;
  /// As labelled: the pose and, where there is one, its mirrored twin; then those relabelled by the target's
  /// symmetries.
  std::vector<Rigid3> camera_from_target;
  std::vector<int> symmetry;  ///< of each candidate; -1: as labelled
  int as_labelled = 1;        ///< how many of the candidates are
  Eigen::Vector3d centre_in_target = Eigen::Vector3d::Zero();
  /// Of each candidate for rays that are 1 rad uncertain: rotation, then translation, in the board's own frame
  /// at its centre, so that views of one board compare without transport.
  std::vector<Eigen::Matrix<double, 6, 6>> covariance;

  double looseness() const { return covariance.front().topLeftCorner<3, 3>().trace(); }
};

/// Views of one board in one moment.
struct SharedBoard {
  int frame = 0;
  int target = 0;
  std::vector<PosedView> views;  ///< at most one for each camera, by camera
};

/// Groups of the views that have poses, by frame and target.
std::vector<SharedBoard> shared_boards(const CalibrationProblem& problem,
                                       const std::vector<std::optional<Rigid3>>& camera_from_target,
                                       const std::vector<std::optional<Rigid3>>& mirrored);

/// How two opinions about the place of a board differ.
struct Disagreement {
  double size = 0.0;  ///< [rad] noise of the rays that would explain it (Mahalanobis distance over sqrt 6)
  int candidate = 0;  ///< of the second view, the one that agrees best
};

/// Compares where view `a` (by its candidate `a_candidate`) puts the board with where view `b` has it.
Disagreement disagreement(const PosedView& a, int a_candidate, const PosedView& b, const Rigid3& b_from_a);

/// Share of the frames that must agree: hand-held boards in front of cameras that are not triggered together move in
/// many of them. Sizes of honest frames lie close together (six numbers are averaged), so that a low quantile measures
/// noise.
constexpr double kQuorum = 0.3;

/// The relative pose of two cameras on which most frames agree.
struct PairConsensus {
  Rigid3 b_from_a;
  int agreeing = 0;     ///< frames
  double spread = 0.0;  ///< Disagreement::size of the frames that agree best, at kQuorum
};

/// Least quantile over the frames, then least squares over those that agree.
///
/// @param pairs  views of the same board by camera a and camera b, at least one
PairConsensus pair_consensus(const std::vector<std::pair<const PosedView*, const PosedView*>>& pairs);

/// A disagreement beyond this is not noise; `spread` as in PairConsensus.
double agreement_limit(double spread);

}  // namespace raybundle
