// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "robust_solve.hpp"

namespace raybundle {

/// The pose from which a board looks nearly the same to its camera.
struct MirroredBoard {
  std::size_t view = 0;
  Rigid3 camera_from_target;
  double growth = 0.0;  ///< of the view's squares, each corner by its sigma, while the camera stays; relative
};

/// Those of a camera's boards that have such a pose.
///
/// @param single  a problem with one camera
std::vector<MirroredBoard> find_mirrored_boards(const CalibrationProblem& single, const BundleState& state,
                                                int threads);

/// Turns the boards that fit better there, while the camera stays; whether there were any.
bool turn_mirrored_boards(BundleState& state, const std::vector<MirroredBoard>& mirrored);

/// A board that fits its mirrored pose nearly as well may fit it better once the camera has moved, too. Tries those by
/// which the cost grows by less than the camera could win back, one by one; whether any was turned. Of many views no
/// single one moves the camera.
bool try_mirrored_boards(const CalibrationProblem& single, std::vector<MirroredBoard> mirrored,
                         const CalibrateOptions& options, SolvedState& solved);

}  // namespace raybundle
