// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "raybundle/geometry/line.hpp"
#include "raybundle/scene/board_surface.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle {

/// A board in a place, and what can be seen on it.
class PlacedBoard {
 public:
  PlacedBoard(const SimulatedBoard& board, const BoardSurface& surface, const Rigid3& rig_from_target)
      : board_(&board), surface_(&surface), rig_from_target_(rig_from_target) {}

  /// Pixel of a place on the board; nothing where the camera does not see it: outside of the image or the used field,
  /// from behind, or at a grazing angle.
  std::optional<Eigen::Vector2d> seen_at(const SimulatedCamera& camera, const Eigen::Vector3d& x_in_target) const;

  /// Where a beam lights the printed side [m, target frame]; nothing where it misses the sheet, or grazes it.
  std::optional<Eigen::Vector3d> spot(const Line3& beam_in_rig) const;

  /// Area of the board that a pixel shows there [m²].
  double pixel_area_m2(const SimulatedCamera& camera, const Eigen::Vector3d& x_in_target) const;

  const Rigid3& rig_from_target() const { return rig_from_target_; }

 private:
  /// Cosine between the printed side's normal and the way to a place in the target frame.
  double facing(const Eigen::Vector3d& x_in_target, const Eigen::Vector3d& towards) const;

  const SimulatedBoard* board_;
  const BoardSurface* surface_;
  Rigid3 rig_from_target_;
};

/// Whether a place of the target is inked.
bool is_ink(const BoardPrint& print, const Eigen::Vector2d& place);

/// Whether a place lies within a box.
bool contains(const BoardPrint::Box& box, const Eigen::Vector2d& place);

}  // namespace raybundle
