// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "saddle_rows.hpp"

namespace raybundle {

/// Gaussian knowledge of each parameter; weight 0 where there is none.
struct SaddlePriors {
  SaddleVector mean = SaddleVector::Zero();
  SaddleVector weight = SaddleVector::Zero();  ///< [grey²] over the parameter's variance
};

struct SaddleFit {
  SaddleVector parameters = SaddleVector::Zero();
  double squares = 0;  ///< Σ weight residual²
  double weights = 0;  ///< Σ weight
  /// Variance of a coordinate, the mean of x and y, for a grey value's variance of 1 [px²]
  double variance_px2 = 0;
};

/// A window and its equations, to be used again and again.
struct SaddleWork {
  SaddleSamples samples;  ///< padded
  SaddleRows rows;
};

/// Least squares from `start`, Levenberg-Marquardt. Given up where the corner has left the window for good.
///
/// @param window_from_pixel  to where the window spans [-1, 1]²
/// @param rough              as in SaddleWindow: settled at .05 px
SaddleFit minimise_saddle(SaddleWork& work, const SaddleVector& start, const SaddlePriors& priors,
                          const SaddleBends& bends, const Eigen::Matrix2d& window_from_pixel, bool rough);

}  // namespace raybundle
