// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace raybundle {

// The model: grey = base + amplitude p + tone p² + (shade · s)(1 + p) / 2 with p = -erf(d_a / √2 blur) erf(d_b / √2
// blur), where d_a, d_b are signed distances from the two edges and s is the sample's place in the window: a product of
// blurred steps (corrected where edges are not perpendicular), seen through a tone curve (the quadratic term:
// over-exposed squares grow), in light that changes over the window, bright squares more than dark ones.
// clang-format off
enum SaddleParameter { kX, kY, kAngleA, kAngleB, kLogBlur, kBase, kAmplitude, kTone, kShadeX, kShadeY, kSaddleParameters };
// clang-format on
using SaddleVector = Eigen::Matrix<double, kSaddleParameters, 1>;
using SaddleMatrix = Eigen::Matrix<double, kSaddleParameters, kSaddleParameters>;

/// A pixel of the window.
struct SaddleSample {
  double x, y;  ///< [px] from the window's centre
  double grey;
  double root_weight;  ///< square root of its weight
};

/// Gaussian knowledge of each parameter; weight 0 where there is none.
struct SaddlePriors {
  SaddleVector mean = SaddleVector::Zero();
  SaddleVector weight = SaddleVector::Zero();  ///< [grey²] over the parameter's variance
};

/// Curvatures of the two edges, known beforehand [1/px].
struct SaddleBends {
  double a = 0.0;
  double b = 0.0;
};

struct SaddleFit {
  SaddleVector parameters = SaddleVector::Zero();
  SaddleMatrix information = SaddleMatrix::Zero();  ///< JᵀWJ with priors
  SaddleMatrix scatter = SaddleMatrix::Zero();      ///< JᵀW²J
  double squares = 0;                               ///< Σ weight residual²
  double weights = 0;                               ///< Σ weight
};

/// Least squares from `start`, Levenberg-Marquardt.
SaddleFit minimise_saddle(const std::vector<SaddleSample>& samples, const SaddleVector& start,
                          const SaddlePriors& priors, const SaddleBends& bends);

}  // namespace raybundle
