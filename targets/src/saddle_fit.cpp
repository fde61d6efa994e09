// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "saddle_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace raybundle {
namespace {

/// erf(z / √2) and its derivative by linear interpolation; error below 1e-5.
struct BlurredStep {
  static constexpr float kEnd = 4.5F;
  static constexpr int kPerUnit = 256;
  static constexpr int kSize = static_cast<int>(2 * kEnd * kPerUnit) + 2;
  struct Entry {
    float step, slope;
  };
  std::array<Entry, kSize> table;
  BlurredStep() {
    for (int i = 0; i < kSize; ++i) {
      const double z = static_cast<double>(i) / kPerUnit - kEnd;
      table[i].step = static_cast<float>(std::erf(z * std::numbers::sqrt2 / 2));
      table[i].slope = static_cast<float>(std::sqrt(2 / std::numbers::pi) * std::exp(-0.5 * z * z));
    }
  }
  Entry at(float z) const {
    const float place = (std::clamp(z, -kEnd, kEnd) + kEnd) * kPerUnit;
    const int i = static_cast<int>(place);
    const float f = place - static_cast<float>(i);
    return {table[i].step + f * (table[i + 1].step - table[i].step),
            table[i].slope + f * (table[i + 1].slope - table[i].slope)};
  }
};

// One column a sample: √weight times its Jacobian row, then its residual; padded to whole SIMD registers. Single
// precision is plenty for the normal equations of a fit that is good to a thousandth of a pixel, and twice as fast.
constexpr int kPadded = 12;
using Rows = Eigen::Matrix<float, kPadded, Eigen::Dynamic>;

struct State {
  SaddleVector parameters;
  SaddleMatrix information;
  SaddleVector gradient;
  double cost = 0;
  double squares = 0;
};

/// Cost and normal equations at `parameters`.
State evaluated(const std::vector<SaddleSample>& samples, const SaddleVector& parameters, const SaddlePriors& priors,
                const SaddleBends& bends, Rows& rows) {
  static const BlurredStep blurred_step;
  const Eigen::Matrix<float, kSaddleParameters, 1> q = parameters.cast<float>();
  const float sharp = std::exp(-q[kLogBlur]);
  const float a_x = std::cos(q[kAngleA]), a_y = std::sin(q[kAngleA]);
  const float b_x = std::cos(q[kAngleB]), b_y = std::sin(q[kAngleB]);
  const float bend_a = static_cast<float>(bends.a), bend_b = static_cast<float>(bends.b);
  const float coupling = a_x * b_x + a_y * b_y;        // cosine between the edges
  const float coupling_wrt_a = a_x * b_y - a_y * b_x;  // and minus that for the other edge's angle
  double squares = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const float sample_x = static_cast<float>(samples[i].x), sample_y = static_cast<float>(samples[i].y);
    const float x = sample_x - q[kX], y = sample_y - q[kY];
    const float t_a = a_x * x + a_y * y, n_a = a_x * y - a_y * x;  // along and across edge a
    const float t_b = b_x * x + b_y * y, n_b = b_x * y - b_y * x;
    const float z_a = (n_a - 0.5F * bend_a * t_a * t_a) * sharp;
    const float z_b = (n_b - 0.5F * bend_b * t_b * t_b) * sharp;
    const auto [step_a, slope_a] = blurred_step.at(z_a);
    const auto [step_b, slope_b] = blurred_step.at(z_b);
    // Blur couples edges that are not perpendicular: the bivariate normal's tetrachoric series to its second term.
    const float both = slope_a * slope_b;
    const float series = 1 + 0.5F * coupling * z_a * z_b;
    const float p = -(step_a * step_b + coupling * both * series);
    const float half_light = 0.5F * (1 + p);
    const float shade = q[kShadeX] * sample_x + q[kShadeY] * sample_y;
    const float model = q[kBase] + p * (q[kAmplitude] + q[kTone] * p) + shade * half_light;
    const float wrt_p = q[kAmplitude] + 2 * q[kTone] * p + 0.5F * shade;
    const float p_wrt_z_a = slope_a * step_b + coupling * both * (0.5F * coupling * z_b - z_a * series);
    const float p_wrt_z_b = slope_b * step_a + coupling * both * (0.5F * coupling * z_a - z_b * series);
    const float wrt_d_a = -wrt_p * p_wrt_z_a * sharp;
    const float wrt_d_b = -wrt_p * p_wrt_z_b * sharp;
    const float wrt_turn = -wrt_p * both * (1 + coupling * z_a * z_b) * coupling_wrt_a;
    const float root = static_cast<float>(samples[i].root_weight);
    const float residual = root * (static_cast<float>(samples[i].grey) - model);
    squares += static_cast<double>(residual) * residual;

    float* row = rows.col(static_cast<Eigen::Index>(i)).data();
    row[kX] = root * (wrt_d_a * (a_y + bend_a * t_a * a_x) + wrt_d_b * (b_y + bend_b * t_b * b_x));
    row[kY] = root * (wrt_d_a * (bend_a * t_a * a_y - a_x) + wrt_d_b * (bend_b * t_b * b_y - b_x));
    row[kAngleA] = root * (wrt_turn - wrt_d_a * t_a * (1 + bend_a * n_a));
    row[kAngleB] = root * (-wrt_turn - wrt_d_b * t_b * (1 + bend_b * n_b));
    row[kLogBlur] = -root * (wrt_d_a * z_a + wrt_d_b * z_b) / sharp;
    row[kBase] = root;
    row[kAmplitude] = root * p;
    row[kTone] = root * p * p;
    row[kShadeX] = root * sample_x * half_light;
    row[kShadeY] = root * sample_y * half_light;
    row[kSaddleParameters] = residual;
    row[kSaddleParameters + 1] = 0;
  }
  Eigen::Matrix<float, kPadded, kPadded> product;
  product.noalias() = rows * rows.transpose();
  const SaddleVector off = priors.mean - parameters;
  State state;
  state.parameters = parameters;
  state.information = product.topLeftCorner<kSaddleParameters, kSaddleParameters>().cast<double>();
  state.information.diagonal() += priors.weight;
  state.gradient = product.col(kSaddleParameters).head<kSaddleParameters>().cast<double>();
  state.gradient += priors.weight.cwiseProduct(off);
  state.squares = squares;
  state.cost = squares + off.dot(priors.weight.cwiseProduct(off));
  return state;
}

}  // namespace

SaddleFit minimise_saddle(const std::vector<SaddleSample>& samples, const SaddleVector& start,
                          const SaddlePriors& priors, const SaddleBends& bends) {
  Rows rows(kPadded, static_cast<Eigen::Index>(samples.size()));
  State best = evaluated(samples, start, priors, bends, rows);
  double damping = 1e-3;
  for (int iteration = 0; iteration < 15; ++iteration) {
    SaddleMatrix damped = best.information;
    damped.diagonal() *= 1 + damping;
    SaddleVector step = damped.ldlt().solve(best.gradient);
    if (!step.allFinite()) break;
    step[kLogBlur] = std::clamp(step[kLogBlur], -0.7, 0.7);
    const double move = step.head<2>().norm();
    const State next = evaluated(samples, best.parameters + step, priors, bends, rows);
    const bool better = next.cost < best.cost;
    const bool settled = best.cost - next.cost < 1e-3 * best.cost && move < 4e-3;
    if (better) best = next;
    if (settled) break;
    damping = better ? 0.2 * damping : 10 * damping;
    if (damping > 1e4) break;
  }
  // The rows are of the last step that was tried: next to the best one, which is good enough for a covariance.
  SaddleFit fit;
  fit.parameters = best.parameters;
  fit.information = best.information;
  fit.squares = best.squares;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    rows.col(static_cast<Eigen::Index>(i)) *= static_cast<float>(samples[i].root_weight);
    fit.weights += samples[i].root_weight * samples[i].root_weight;
  }
  const Eigen::Matrix<float, kPadded, kPadded> product = rows * rows.transpose();
  fit.scatter = product.topLeftCorner<kSaddleParameters, kSaddleParameters>().cast<double>();
  return fit;
}

}  // namespace raybundle
