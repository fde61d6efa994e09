// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/initialize/beam_start.hpp"
#include "raybundle/scene/board_surface.hpp"

namespace raybundle {

/// A dot as a point in space: where its camera ray meets the board.
struct BeamHit {
  int view = 0;  ///< indices into problem.views and its dots
  int dot = 0;
  Eigen::Vector3d x_in_rig = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m²], of rank two: the point cannot leave the board
  double cosine = 1.0;  ///< between the camera's ray and the board's normal: matt paper sends less light aside
};

/// Which dots lie on their board: where the camera's ray meets it amid its points, or no farther beyond the outermost
/// than one and a half times what these are apart. All dots of views that are not used are off.
///
/// @return  aligned with problem.views and their dots
std::vector<std::vector<bool>> dots_on_boards(const LaserScene& scene);

/// Hits of the dots on their boards, in the order of views and dots. Left out are dots whose ray grazes the board:
/// there the place along the ray, hence along the beam, is hardly determined.
std::vector<BeamHit> hits_on_boards(const LaserScene& scene, const std::vector<std::vector<bool>>& on_board);

/// Hit of a ray through any pixel of a view, for a dot that may not be in the list; nothing for views that are not
/// used, and as for hits_on_boards().
std::optional<BeamHit> hit_at(const LaserScene& scene, int view, const Eigen::Vector2d& pixel);

/// Squared distance of a hit from a line, in sigmas of the hit plus `line_covariance` [m²] of the line at that place.
/// About chi-squared with two degrees of freedom when the beam made the dot.
double squared_sigmas(const Line3& line, const BeamHit& hit,
                      const Eigen::Matrix3d& line_covariance = Eigen::Matrix3d::Zero());

/// The boards of all views that have dots, for lines to meet them. Surveyed landmarks, which are no board, have none.
class LaserBoards {
 public:
  explicit LaserBoards(const LaserScene& scene);

  /// Whether a dot is to be expected: the line meets the board of this view, which has dots, amid its points, and the
  /// camera sees it.
  bool expects_dot(int view, const Line3& line) const;

 private:
  const LaserScene& scene_;
  std::vector<std::optional<BoardSurface>> surfaces_;   // aligned with problem.targets
  std::vector<std::optional<Rigid3>> target_from_rig_;  // aligned with problem.views
};

}  // namespace raybundle
