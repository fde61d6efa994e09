// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "saddle_rows.hpp"

#include <cmath>

// The functions that are marked so are compiled twice on x86: for every processor, and for those with AVX2. Fused
// multiply-add is not among what AVX2 means here and sums are kept in the same eight lanes, so both give the same bits.
#define RAYBUNDLE_INLINE [[gnu::always_inline]] inline

namespace raybundle {
namespace {

constexpr int kLanes = SaddleSamples::kLanes;
using Lanes [[gnu::vector_size(sizeof(float) * kLanes), gnu::may_alias]] = float;

/// What the loop over samples needs of the parameters.
struct Model {
  float x, y;  // of the corner
  float a_x, a_y, b_x, b_y, half_bend_a, half_bend_b;
  float sharp, blur;
  float coupling;        // cosine between the edges
  float coupling_wrt_a;  // and minus that for the other edge's angle
  float base, amplitude, tone, shade_x, shade_y;
};

Model model_of(const SaddleVector& parameters, const SaddleBends& bends) {
  const Eigen::Matrix<float, kSaddleParameters, 1> q = parameters.cast<float>();
  Model m;
  m.x = q[kX], m.y = q[kY];
  m.a_x = std::cos(q[kAngleA]), m.a_y = std::sin(q[kAngleA]);
  m.b_x = std::cos(q[kAngleB]), m.b_y = std::sin(q[kAngleB]);
  m.half_bend_a = 0.5F * static_cast<float>(bends.a), m.half_bend_b = 0.5F * static_cast<float>(bends.b);
  m.sharp = std::exp(-q[kLogBlur]), m.blur = 1 / m.sharp;
  m.coupling = m.a_x * m.b_x + m.a_y * m.b_y;
  m.coupling_wrt_a = m.a_x * m.b_y - m.a_y * m.b_x;
  m.base = q[kBase], m.amplitude = q[kAmplitude], m.tone = q[kTone];
  m.shade_x = q[kShadeX], m.shade_y = q[kShadeY];
  return m;
}

/// erf(z / √2) and its derivative; error below 1e-6.
/// Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 7.1.26; the exponential is the sixteenth power of
/// its Taylor series to the sixth term.
RAYBUNDLE_INLINE void blurred_step(const Lanes& z, Lanes& step, Lanes& slope) {
  constexpr float kEnd = 4.5F;
  const Lanes size = z < 0 ? -z : z;
  const Lanes far = size < kEnd ? size : kEnd - 0 * z;
  const Lanes u = far * far * (-0.5F / 16);
  Lanes power = 1 + u * (1 + u * (0.5F + u * (1.0F / 6 + u * (1.0F / 24 + u * (1.0F / 120 + u * (1.0F / 720))))));
  power *= power;
  power *= power;
  power *= power;
  power *= power;
  const Lanes t = 1 / (1 + (0.3275911F * 0.70710678F) * far);
  const Lanes tail =
      t * (0.254829592F + t * (-0.284496736F + t * (1.421413741F + t * (-1.453152027F + t * 1.061405429F))));
  const Lanes positive = 1 - tail * power;
  step = z < 0 ? -positive : positive;
  slope = 0.79788456F * power;
}

RAYBUNDLE_INLINE const Lanes& lanes(const float* from) { return *reinterpret_cast<const Lanes*>(from); }

RAYBUNDLE_INLINE void write_rows(const SaddleSamples& samples, const Model& m, SaddleRows& rows) {
  const int n = samples.padded();
  for (int i = 0; i < n; i += kLanes) {
    const Lanes sample_x = lanes(samples.x + i), sample_y = lanes(samples.y + i);
    const Lanes root = lanes(samples.root_weight + i);
    const auto row = [&](int which) __attribute__((always_inline))->Lanes& {
      return *reinterpret_cast<Lanes*>(rows.values[which] + i);
    };
    const Lanes x = sample_x - m.x, y = sample_y - m.y;
    const Lanes t_a = m.a_x * x + m.a_y * y, n_a = m.a_x * y - m.a_y * x;  // along and across edge a
    const Lanes t_b = m.b_x * x + m.b_y * y, n_b = m.b_x * y - m.b_y * x;
    const Lanes z_a = (n_a - m.half_bend_a * t_a * t_a) * m.sharp;
    const Lanes z_b = (n_b - m.half_bend_b * t_b * t_b) * m.sharp;
    Lanes step_a, slope_a, step_b, slope_b;
    blurred_step(z_a, step_a, slope_a);
    blurred_step(z_b, step_b, slope_b);
    // Blur couples edges that are not perpendicular: the bivariate normal's tetrachoric series to its second term.
    const Lanes both = slope_a * slope_b, coupled = m.coupling * both;
    const Lanes series = 1 + 0.5F * m.coupling * z_a * z_b;
    const Lanes p = -(step_a * step_b + coupled * series);
    const Lanes half_light = 0.5F * (1 + p);
    const Lanes shade = m.shade_x * sample_x + m.shade_y * sample_y;
    const Lanes model = m.base + p * (m.amplitude + m.tone * p) + shade * half_light;
    const Lanes wrt_p = root * (m.amplitude + 2 * m.tone * p + 0.5F * shade);
    const Lanes wrt_z_a = wrt_p * (slope_a * step_b + coupled * (0.5F * m.coupling * z_b - z_a * series));
    const Lanes wrt_z_b = wrt_p * (slope_b * step_a + coupled * (0.5F * m.coupling * z_a - z_b * series));
    const Lanes wrt_d_a = -wrt_z_a * m.sharp, wrt_d_b = -wrt_z_b * m.sharp;
    const Lanes wrt_turn = -m.coupling_wrt_a * wrt_p * both * (1 + m.coupling * z_a * z_b);
    const Lanes bent_a = 2 * m.half_bend_a * t_a, bent_b = 2 * m.half_bend_b * t_b;
    row(kX) = wrt_d_a * (m.a_y + bent_a * m.a_x) + wrt_d_b * (m.b_y + bent_b * m.b_x);
    row(kY) = wrt_d_a * (bent_a * m.a_y - m.a_x) + wrt_d_b * (bent_b * m.b_y - m.b_x);
    row(kAngleA) = wrt_turn - wrt_d_a * (t_a + bent_a * n_a);
    row(kAngleB) = -wrt_turn - wrt_d_b * (t_b + bent_b * n_b);
    row(kLogBlur) = wrt_z_a * z_a + wrt_z_b * z_b;
    row(kBase) = root;
    row(kAmplitude) = root * p;
    row(kTone) = root * p * p;
    row(kShadeX) = root * sample_x * half_light;
    row(kShadeY) = root * sample_y * half_light;
    row(kSaddleParameters) = root * (lanes(samples.grey + i) - model);
  }
}

/// Products of row `first` with rows begin to begin + kWidth - 1.
template <int kWidth>
RAYBUNDLE_INLINE void write_products(const SaddleRows& rows, int n, int first, int begin, SaddleProduct& product) {
  Lanes sums[kWidth] = {};
  for (int i = 0; i < n; i += kLanes) {
    const Lanes one = lanes(rows.values[first] + i);
    for (int k = 0; k < kWidth; ++k) sums[k] += one * lanes(rows.values[begin + k] + i);
  }
  for (int k = 0; k < kWidth; ++k) {
    float sum = 0;
    for (int lane = 0; lane < kLanes; ++lane) sum += sums[k][lane];
    product(first, begin + k) = product(begin + k, first) = sum;
  }
}

RAYBUNDLE_INLINE void write_all_products(const SaddleRows& rows, int n, SaddleProduct& product) {
  constexpr int kWidth =
      6;  // as many sums as registers hold; rows before the diagonal are computed twice or not at all
  for (int first = 0; first < SaddleRows::kCount; ++first) {
    write_products<kWidth>(rows, n, first, SaddleRows::kCount - kWidth, product);
    if (first < SaddleRows::kCount - kWidth) write_products<SaddleRows::kCount - kWidth>(rows, n, first, 0, product);
  }
}

RAYBUNDLE_INLINE void equations(const SaddleSamples& samples, const Model& model, SaddleRows& rows,
                                SaddleProduct& product) {
  write_rows(samples, model, rows);
  write_all_products(rows, samples.padded(), product);
}

void equations_anywhere(const SaddleSamples& samples, const Model& model, SaddleRows& rows, SaddleProduct& product) {
  equations(samples, model, rows, product);
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] void equations_avx2(const SaddleSamples& samples, const Model& model, SaddleRows& rows,
                                            SaddleProduct& product) {
  equations(samples, model, rows, product);
}
const bool kAvx2 = __builtin_cpu_supports("avx2");
#endif

}  // namespace

void SaddleSamples::pad() {
  for (int i = size; i < padded(); ++i) x[i] = y[i] = grey[i] = root_weight[i] = 0;
}

SaddleProduct saddle_equations(const SaddleSamples& samples, const SaddleVector& parameters, const SaddleBends& bends,
                               SaddleRows& rows) {
  SaddleProduct product;
  const Model model = model_of(parameters, bends);
#if defined(__x86_64__)
  if (kAvx2) {
    equations_avx2(samples, model, rows, product);
    return product;
  }
#endif
  equations_anywhere(samples, model, rows, product);
  return product;
}

double weighted_square(const SaddleSamples& samples, const SaddleRows& rows,
                       const Eigen::Matrix<float, kSaddleParameters, 1>& combination) {
  Lanes sums = {};
  for (int i = 0; i < samples.padded(); i += kLanes) {
    Lanes value = combination[0] * lanes(rows.values[0] + i);
    for (int k = 1; k < kSaddleParameters; ++k) value += combination[k] * lanes(rows.values[k] + i);
    value *= lanes(samples.root_weight + i);
    sums += value * value;
  }
  double sum = 0;
  for (int lane = 0; lane < kLanes; ++lane) sum += sums[lane];
  return sum;
}

}  // namespace raybundle
