// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "problem.hpp"

namespace raybundle::bench {

/// The least true error that any unbiased estimator can have on average.
struct TrueErrorBound {
  double rms_px = 0.0;  ///< root of the mean expected squared distance over the grid
};

/// Cramér-Rao bound of the projection over the grid of one camera: the inverse of the full bundle's information at the
/// truth, propagated to the pixels of the grid after the best rotation (which the board poses take up) is removed.
///
/// @param with_shape  the board's bend and twist are estimated too
TrueErrorBound true_error_bound(const PeerProblem& problem, int camera, bool with_shape);

/// What an estimated camera gets wrong over the grid once the best rotation of the rays is removed.
struct TrueError {
  double rms_px = 0.0;
  double max_px = 0.0;
  Eigen::Quaterniond estimated_from_true = Eigen::Quaterniond::Identity();  ///< the rotation that was removed
  int unprojectable = 0;  ///< grid points that the camera does not project; not in rms_px
};

TrueError true_error(const std::vector<GridPoint>& grid, const Camera& estimated);

}  // namespace raybundle::bench
