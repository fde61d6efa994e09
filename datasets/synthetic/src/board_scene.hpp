// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "raybundle/scene/board_surface.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle {

/// The bent board as a body that rays meet, in the target's frame. Embree tells what a ray meets first on a mesh of
/// triangles; the place itself is then found in closed form on the true surface, in double precision.
class BoardScene {
 public:
  /// @throws Error(kBadInput) when the target is not flat
  explicit BoardScene(const SimulatedBoard& board);

  /// Places on the board, or on a border around it, that rays from one point meet first; NaN where they meet none.
  ///
  /// @param directions  of any length; NaN: no ray
  std::vector<Eigen::Vector2d> places(const Eigen::Vector3d& origin,
                                      const std::vector<Eigen::Vector3d>& directions) const;

  /// Where a ray meets the sheet; nothing where it misses.
  std::optional<Eigen::Vector3d> sheet_crossing(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// Where a ray meets the surface, which reaches beyond the sheet.
  std::optional<Eigen::Vector3d> crossing(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// Whether any place of the rectangle around these places is on the sheet.
  bool near_sheet(const std::vector<Eigen::Vector3d>& places) const;

  /// Of unit length, on the side of positive z.
  Eigen::Vector3d normal(const Eigen::Vector2d& place) const;

  Eigen::Vector3d on_surface(const Eigen::Vector2d& place) const { return {place.x(), place.y(), height(place)}; }

 private:
  double height(const Eigen::Vector2d& place) const;

  BoardPrint::Box sheet_;
  double c_ = 0, x_ = 0, y_ = 0, xx_ = 0, yy_ = 0, xy_ = 0;  // height = c + x X + y Y + xx X² + yy Y² + xy X Y
  std::shared_ptr<void> mesh_;                               // Embree's scene
};

}  // namespace raybundle
