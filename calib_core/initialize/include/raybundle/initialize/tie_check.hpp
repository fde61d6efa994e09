// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// How much worse the views of a frame fit with one board pose for all cameras than with one for each.
struct TieCheck {
  int pose = 0;                            ///< index into the poses
  std::vector<int> views;                  ///< that share it, two or more
  std::vector<Rigid3> camera_from_target;  ///< the views' own poses, aligned with `views`
  double tied_rms_px = 0.0;
  double own_rms_px = 0.0;  ///< with a pose for each view
  double excess = 0.0;      ///< [noise sigmas] per degree of freedom that the tie takes away; about 1 when it is right
  std::string reason;       ///< `left and right fit to 0.45 px together but to 0.18 px apart`
};

/// Holds every shared board pose of a solved rig against the views' own poses under the same cameras. Boards that moved
/// between exposures too little for initialize_rig to see stand out here, in pixels.
///
/// @param cameras, camera_from_rig  aligned with problem.cameras
/// @param shapes                    aligned with problem.targets: a bent board taken as flat seems to have moved
/// @param pose_of_view              aligned with problem.views; -1: not used
std::vector<TieCheck> check_ties(const CalibrationProblem& problem, const std::vector<Camera>& cameras,
                                 const std::vector<Rigid3>& camera_from_rig, const std::vector<BoardShape>& shapes,
                                 const std::vector<BoardPose>& poses, const std::vector<int>& pose_of_view,
                                 int threads = 1);

}  // namespace raybundle
