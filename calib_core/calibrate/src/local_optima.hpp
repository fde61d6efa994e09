// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// Where a camera alone has come to.
struct CameraOptimum {
  BundleSummary summary;  ///< of the last solve
  /// projection_sigma_px() of the state, or more where lenses that fit as well project otherwise; NaN when the solve
  /// failed.
  double projection_sigma_px = 0.0;
};

/// Leaves the optima of a solved camera that lie beside the right one: boards held by their mirrored pose, and lenses
/// whose model has a twin that fits better. The state changes only to one of lower cost.
///
/// @param single   a problem with one camera
/// @param reasons  aligned with problem.views
/// @param solved   how the state came about
/// @return         with `solved` where nothing was better
CameraOptimum leave_local_optima(const CalibrationProblem& single, BundleState& state, const CalibrateOptions& options,
                                 std::vector<std::string>& reasons, const BundleSummary& solved);

/// Moves to the lowest optimum of a lens that puts corners nearly where the state's does, as near as they can tell, if
/// it is lower than where the state is: by more than noise makes it where it leaves open a lens that was not and that
/// projects nearly alike.
///
/// @param optimum  of the state; of the new one when it moves
/// @return         whether it moved
bool move_to_lower_alike(const CalibrationProblem& single, BundleState& state, const CalibrateOptions& options,
                         CameraOptimum& optimum);

/// Rays of corners in use, spread over the views, through the solved camera: some hundreds of them.
std::vector<Eigen::Vector3d> rays_seen(const CalibrationProblem& single, const BundleState& state);

/// The poses from which the boards look nearly the same to their camera; other cameras of a rig may know better.
///
/// @param single  a problem with one camera, solved
/// @return        aligned with problem.views; empty where the pixels tell
std::vector<std::optional<Rigid3>> mirrored_boards(const CalibrationProblem& single, const BundleState& state);

}  // namespace raybundle
