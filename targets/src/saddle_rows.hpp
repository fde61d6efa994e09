// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

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

/// Curvatures of the two edges, known beforehand [1/px].
struct SaddleBends {
  double a = 0.0;
  double b = 0.0;
};

/// The pixels of a window, one array for each quantity, so that a processor works on several samples at once.
struct SaddleSamples {
  static constexpr int kMost = 768;                 ///< whole pairs of groups; a window of 23x23 and its border fit
  static constexpr int kLanes = 8;                  ///< samples of a group
  static constexpr int kRoom = kMost + 2 * kLanes;  ///< and one of no weight
  int size = 0;
  double weights = 0;                    ///< sum of all weights
  alignas(64) float x[kRoom], y[kRoom];  ///< [px] from the window's centre
  alignas(64) float grey[kRoom];         ///< grey values
  alignas(64) float root_weight[kRoom];  ///< square root of the sample's weight

  /// A sample of no weight is written, and overwritten by the next one: no branch to be foreseen.
  void add(float at_x, float at_y, float value, float root) {
    x[size] = at_x, y[size] = at_y, grey[size] = value, root_weight[size] = root;
    weights += root * root;
    size += static_cast<int>(root > 0) & static_cast<int>(size < kMost);
  }
  /// Fills the last pair of groups with samples of no weight.
  void pad();
  int padded() const { return (size + 2 * kLanes - 1) / (2 * kLanes) * (2 * kLanes); }
  int groups() const { return padded() / kLanes; }
};

/// Weighted rows of the least squares problem: its Jacobian's columns, then the residual. Single precision is plenty
/// for the normal equations of a fit that is good to a thousandth of a pixel, and twice as fast.
struct SaddleRows {
  static constexpr int kCount = kSaddleParameters + 1;
  static constexpr int kPadded = kCount + 1;  ///< with a row of zeros: rows are multiplied in pairs
  /// The rows of one group of samples stand together, so that the widest registers take two at once.
  alignas(64) float values[SaddleSamples::kMost / SaddleSamples::kLanes][kPadded][SaddleSamples::kLanes];
};

/// Sums of products of all pairs of rows.
using SaddleProduct = Eigen::Matrix<float, SaddleRows::kCount, SaddleRows::kCount>;

/// Writes the rows at these parameters and gives their products. The bits do not depend on the processor.
///
/// @param samples  padded
SaddleProduct saddle_equations(const SaddleSamples& samples, const SaddleVector& parameters, const SaddleBends& bends,
                               SaddleRows& rows);

/// Sum of the squares of a combination of the Jacobian's columns, each sample multiplied by its root weight once more.
double weighted_square(const SaddleSamples& samples, const SaddleRows& rows,
                       const Eigen::Matrix<float, kSaddleParameters, 1>& combination);

}  // namespace raybundle
