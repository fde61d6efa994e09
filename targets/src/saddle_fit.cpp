// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "saddle_fit.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/target_clones.hpp"

namespace raybundle {
namespace {

struct State {
  SaddleVector parameters;
  SaddleMatrix information;
  SaddleVector gradient;
  double cost = 0;
  double squares = 0;
};

/// Cost and normal equations at `parameters`.
State evaluated(SaddleWork& work, const SaddleVector& parameters, const SaddlePriors& priors,
                const SaddleBends& bends) {
  const SaddleProduct product = saddle_equations(work.samples, parameters, bends, work.rows);
  const SaddleVector off = priors.mean - parameters;
  State state;
  state.parameters = parameters;
  state.information = product.topLeftCorner<kSaddleParameters, kSaddleParameters>().cast<double>();
  state.information.diagonal() += priors.weight;
  state.gradient = product.col(kSaddleParameters).head<kSaddleParameters>().cast<double>();
  state.gradient += priors.weight.cwiseProduct(off);
  state.squares = product(kSaddleParameters, kSaddleParameters);
  state.cost = state.squares + off.dot(priors.weight.cwiseProduct(off));
  return state;
}

/// Cholesky's factor of a matrix of this one size, below the diagonal; the diagonal holds its inverse. A fit solves a
/// dozen of these systems, and a general solver takes longer for them than the sums over the window do. Column by column,
/// so that a processor works on several rows at once.
struct Factor {
  static constexpr int kRows = 12;  // whole registers; what stands above the diagonal and in the last two means nothing
  double l[kSaddleParameters][kRows] = {};  // [column][row]

  /// `damping` is added to the diagonal, as a part of it. Singular directions get no step.
  Factor(const SaddleMatrix& matrix, double damping) {
    for (int j = 0; j < kSaddleParameters; ++j) {
      for (int i = 0; i < kSaddleParameters; ++i) l[j][i] = matrix(i, j);
      l[j][j] *= 1 + damping;
    }
    decompose(matrix);
  }

  // For every processor and for wide registers.
  RAYBUNDLE_TARGET_CLONES void decompose(const SaddleMatrix& matrix) {
    for (int k = 0; k < kSaddleParameters; ++k) {
      const double pivot = l[k][k];
      const double inverse = pivot > 1e-12 * matrix(k, k) ? 1 / std::sqrt(pivot) : 0;
      for (int i = 0; i < kRows; ++i) l[k][i] *= inverse;
      l[k][k] = inverse;
      for (int j = k + 1; j < kSaddleParameters; ++j) {
        const double factor = l[k][j];
        for (int i = 0; i < kRows; ++i) l[j][i] -= l[k][i] * factor;
      }
    }
  }

  SaddleVector solve(SaddleVector b) const {
    for (int k = 0; k < kSaddleParameters; ++k) {
      b[k] *= l[k][k];
      for (int i = k + 1; i < kSaddleParameters; ++i) b[i] -= l[k][i] * b[k];
    }
    for (int i = kSaddleParameters - 1; i >= 0; --i) {
      for (int k = i + 1; k < kSaddleParameters; ++k) b[i] -= l[i][k] * b[k];
      b[i] *= l[i][i];
    }
    return b;
  }
};

/// (JᵀWJ)⁻¹ JᵀW²J (JᵀWJ)⁻¹, of which only the corner's place is wanted.
double position_variance(const SaddleWork& work, const SaddleMatrix& information) {
  const Factor factor(information, 0);
  const Eigen::Matrix<float, kSaddleParameters, 1> of_x = factor.solve(SaddleVector::Unit(kX)).cast<float>();
  const Eigen::Matrix<float, kSaddleParameters, 1> of_y = factor.solve(SaddleVector::Unit(kY)).cast<float>();
  return 0.5 * (weighted_square(work.samples, work.rows, of_x) + weighted_square(work.samples, work.rows, of_y));
}

}  // namespace

SaddleFit minimise_saddle(SaddleWork& work, const SaddleVector& start, const SaddlePriors& priors,
                          const SaddleBends& bends, const Eigen::Matrix2d& window_from_pixel, bool rough) {
  State best = evaluated(work, start, priors, bends);
  constexpr double kFarthest = 1.5;  // half-windows: a step may overshoot
  constexpr double kSettled = 1e-3;  // of the cost that is left
  const double settled_px = rough ? 0.05 : 0.004;
  double damping = 1e-3;
  bool rows_are_best = true;
  for (int iteration = 0; iteration < 15; ++iteration) {
    SaddleVector step = Factor(best.information, damping).solve(best.gradient);
    if (!step.allFinite()) break;
    step[kLogBlur] = std::clamp(step[kLogBlur], -0.7, 0.7);
    const bool last = step.head<2>().norm() < settled_px && step.dot(best.gradient) < kSettled * best.cost;
    if (last && rows_are_best) {  // taken without a look at where it leads
      best.parameters += step;
      break;
    }
    const State next = evaluated(work, best.parameters + step, priors, bends);
    const bool better = next.cost < best.cost;
    if (better) best = next;
    rows_are_best = better;
    if (last || (window_from_pixel * best.parameters.head<2>()).cwiseAbs().maxCoeff() > kFarthest) break;
    damping = better ? 0.2 * damping : 10 * damping;
    if (damping > 1e4) break;
  }
  if (!rows_are_best) evaluated(work, best.parameters, priors, bends);
  SaddleFit fit;
  fit.parameters = best.parameters;
  fit.squares = best.squares;
  fit.weights = work.samples.weights;
  // The rows may be those before the last step: next to the best, which is good enough for a covariance.
  fit.variance_px2 = position_variance(work, best.information);
  return fit;
}

}  // namespace raybundle
