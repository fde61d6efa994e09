// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// Start values of the rig from the cameras' own board poses.
struct RigStart {
  std::vector<Rigid3> camera_from_rig;  ///< the first is the identity
  std::vector<BoardPose> poses;
  std::vector<int> pose_of_view;      ///< aligned with problem.views; -1 where the view has no pose
  std::vector<int> symmetry_of_view;  ///< -1: as labelled; k: relabel by target.symmetries[k]
};

/// Links the cameras through frames in which they see the same board: for each pair the relative pose on which most
/// frames agree, then the spanning tree with the most frames. Symmetric boards are relabelled where that makes a frame
/// agree, and boards that one camera can hold in two poses are held as the others see them. In a frame that
/// still disagrees each view gets a board pose of its own.
///
/// @param camera_from_target  aligned with problem.views; empty where the view has no pose
/// @param mirrored            other poses that explain the view nearly as well, where there are any; may be empty
/// @throws Error(kNotEnoughData) naming the cameras that no chain of shared frames links to the first
RigStart initialize_rig(const CalibrationProblem& problem, const std::vector<std::optional<Rigid3>>& camera_from_target,
                        const std::vector<std::optional<Rigid3>>& mirrored = {});

}  // namespace raybundle
