// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "saddle_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

// The functions that are marked so are compiled three times on x86: for every processor, for those with AVX2 and for
// those with AVX-512. Multiplications and additions are not fused (this file is compiled with -ffp-contract=off) and
// sums are kept in the same eight lanes, so all give the same bits.
#define RAYBUNDLE_INLINE [[gnu::always_inline]] inline

namespace raybundle {
namespace {

constexpr int kLanes = SaddleSamples::kLanes;
using Lanes [[gnu::vector_size(sizeof(float) * kLanes), gnu::may_alias]] = float;
using Pair [[gnu::vector_size(sizeof(float) * 2 * kLanes), gnu::may_alias]] = float;  // two groups, or two rows of one

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
template <typename Values>
RAYBUNDLE_INLINE void blurred_step(const Values& z, Values& step, Values& slope) {
  constexpr float kEnd = 4.5F;
  const Values size = z < 0 ? -z : z;
  const Values far = size < kEnd ? size : kEnd - 0 * z;
  const Values u = far * far * (-0.5F / 16);
  Values power = 1 + u * (1 + u * (0.5F + u * (1.0F / 6 + u * (1.0F / 24 + u * (1.0F / 120 + u * (1.0F / 720))))));
  power *= power;
  power *= power;
  power *= power;
  power *= power;
  const Values t = 1 / (1 + (0.3275911F * 0.70710678F) * far);
  const Values tail =
      t * (0.254829592F + t * (-0.284496736F + t * (1.421413741F + t * (-1.453152027F + t * 1.061405429F))));
  const Values positive = 1 - tail * power;
  step = z < 0 ? -positive : positive;
  slope = 0.79788456F * power;
}

template <typename Values>
RAYBUNDLE_INLINE const Values& values_at(const float* from) {
  return *reinterpret_cast<const Values*>(from);
}

RAYBUNDLE_INLINE void store(const Lanes& values, SaddleRows& rows, int group, int row) {
  *reinterpret_cast<Lanes*>(rows.values[group][row]) = values;
}

RAYBUNDLE_INLINE void store(const Pair& values, SaddleRows& rows, int group, int row) {
  store(__builtin_shufflevector(values, values, 0, 1, 2, 3, 4, 5, 6, 7), rows, group, row);
  store(__builtin_shufflevector(values, values, 8, 9, 10, 11, 12, 13, 14, 15), rows, group + 1, row);
}

/// `Values` is as many samples as a register holds.
template <typename Values>
RAYBUNDLE_INLINE void write_rows(const SaddleSamples& samples, const Model& m, SaddleRows& rows) {
  constexpr int kStep = sizeof(Values) / sizeof(float);
  const int n = samples.padded();
  for (int i = 0; i < n; i += kStep) {
    const Values sample_x = values_at<Values>(samples.x + i), sample_y = values_at<Values>(samples.y + i);
    const Values root = values_at<Values>(samples.root_weight + i);
    const auto put = [&](int which, const Values& values) __attribute__((always_inline)) {
      store(values, rows, i / kLanes, which);
    };
    const Values x = sample_x - m.x, y = sample_y - m.y;
    const Values t_a = m.a_x * x + m.a_y * y, n_a = m.a_x * y - m.a_y * x;  // along and across edge a
    const Values t_b = m.b_x * x + m.b_y * y, n_b = m.b_x * y - m.b_y * x;
    const Values z_a = (n_a - m.half_bend_a * t_a * t_a) * m.sharp;
    const Values z_b = (n_b - m.half_bend_b * t_b * t_b) * m.sharp;
    Values step_a, slope_a, step_b, slope_b;
    blurred_step(z_a, step_a, slope_a);
    blurred_step(z_b, step_b, slope_b);
    // Blur couples edges that are not perpendicular: the bivariate normal's tetrachoric series to its second term.
    const Values both = slope_a * slope_b, coupled = m.coupling * both;
    const Values series = 1 + 0.5F * m.coupling * z_a * z_b;
    const Values p = -(step_a * step_b + coupled * series);
    const Values half_light = 0.5F * (1 + p);
    const Values shade = m.shade_x * sample_x + m.shade_y * sample_y;
    const Values model = m.base + p * (m.amplitude + m.tone * p) + shade * half_light;
    const Values wrt_p = root * (m.amplitude + 2 * m.tone * p + 0.5F * shade);
    const Values wrt_z_a = wrt_p * (slope_a * step_b + coupled * (0.5F * m.coupling * z_b - z_a * series));
    const Values wrt_z_b = wrt_p * (slope_b * step_a + coupled * (0.5F * m.coupling * z_a - z_b * series));
    const Values wrt_d_a = -wrt_z_a * m.sharp, wrt_d_b = -wrt_z_b * m.sharp;
    const Values wrt_turn = -m.coupling_wrt_a * wrt_p * both * (1 + m.coupling * z_a * z_b);
    const Values bent_a = 2 * m.half_bend_a * t_a, bent_b = 2 * m.half_bend_b * t_b;
    put(kX, wrt_d_a * (m.a_y + bent_a * m.a_x) + wrt_d_b * (m.b_y + bent_b * m.b_x));
    put(kY, wrt_d_a * (bent_a * m.a_y - m.a_x) + wrt_d_b * (bent_b * m.b_y - m.b_x));
    put(kAngleA, wrt_turn - wrt_d_a * (t_a + bent_a * n_a));
    put(kAngleB, -wrt_turn - wrt_d_b * (t_b + bent_b * n_b));
    put(kLogBlur, wrt_z_a * z_a + wrt_z_b * z_b);
    put(kBase, root);
    put(kAmplitude, root * p);
    put(kTone, root * p * p);
    put(kShadeX, root * sample_x * half_light);
    put(kShadeY, root * sample_y * half_light);
    put(kSaddleParameters, root * (values_at<Values>(samples.grey + i) - model));
    put(SaddleRows::kCount, 0 * root);
  }
}

RAYBUNDLE_INLINE void repeat(const Lanes& row, Lanes& repeated) { repeated = row; }
RAYBUNDLE_INLINE void repeat(const Lanes& row, Pair& repeated) {
  repeated = __builtin_shufflevector(row, row, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7);
}

template <typename Values>
constexpr int kRowsIn = sizeof(Values) / (sizeof(float) * kLanes);  // a register

/// Products of kFirsts rows, from kFirst on, with the rows from kBegin on, kSums registers of them at once.
template <typename Values, int kFirst, int kFirsts, int kBegin, int kSums>
RAYBUNDLE_INLINE void write_products(const SaddleRows& rows, int groups, SaddleProduct& product) {
  constexpr int kRows = kRowsIn<Values>;
  Values sums[kFirsts][kSums] = {};
  for (int group = 0; group < groups; ++group) {
    const auto& of_group = rows.values[group];
    for (int f = 0; f < kFirsts; ++f) {
      Values row;
      repeat(values_at<Lanes>(of_group[kFirst + f]), row);
      for (int k = 0; k < kSums; ++k) sums[f][k] += row * values_at<Values>(of_group[kBegin + kRows * k]);
    }
  }
  for (int f = 0; f < kFirsts; ++f) {
    for (int k = 0; k < kRows * kSums && kBegin + k < SaddleRows::kCount; ++k) {
      float sum = 0;
      for (int lane = 0; lane < kLanes; ++lane) sum += sums[f][k / kRows][k % kRows * kLanes + lane];
      product(kFirst + f, kBegin + k) = product(kBegin + k, kFirst + f) = sum;
    }
  }
}

/// @tparam kFirsts, kMost  rows and registers of other rows at once: as many sums as there are registers for
template <typename Values, int kFirsts, int kMost, int kFirst = 0, int kBegin = 0>
RAYBUNDLE_INLINE void write_all_products(const SaddleRows& rows, int groups, SaddleProduct& product) {
  constexpr int kRows = kRowsIn<Values>;
  constexpr int kSums = std::min(kMost, (SaddleRows::kCount - kBegin + kRows - 1) / kRows);
  constexpr int kNext = kFirst + kFirsts, kEnd = kBegin + kRows * kSums;
  write_products<Values, kFirst, std::min(kFirsts, SaddleRows::kCount - kFirst), kBegin, kSums>(rows, groups, product);
  if constexpr (kEnd < SaddleRows::kCount) {
    write_all_products<Values, kFirsts, kMost, kFirst, kEnd>(rows, groups, product);
  } else if constexpr (kNext < SaddleRows::kCount) {
    write_all_products<Values, kFirsts, kMost, kNext, kNext / kRows * kRows>(rows, groups, product);
  }
}

template <typename Values, int kFirsts, int kMost>
RAYBUNDLE_INLINE void equations(const SaddleSamples& samples, const Model& model, SaddleRows& rows,
                                SaddleProduct& product) {
  write_rows<Values>(samples, model, rows);
  write_all_products<Values, kFirsts, kMost>(rows, samples.groups(), product);
}

void equations_anywhere(const SaddleSamples& samples, const Model& model, SaddleRows& rows, SaddleProduct& product) {
  equations<Lanes, 1, 6>(samples, model, rows, product);
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] void equations_avx2(const SaddleSamples& samples, const Model& model, SaddleRows& rows,
                                            SaddleProduct& product) {
  equations<Lanes, 1, 11>(samples, model, rows, product);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void equations_avx512(const SaddleSamples& samples, const Model& model,
                                                                   SaddleRows& rows, SaddleProduct& product) {
  equations<Pair, 2, 6>(samples, model, rows, product);
}
const bool kAvx2 = __builtin_cpu_supports("avx2");
const bool kAvx512 =
    __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
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
  if (kAvx512) {
    equations_avx512(samples, model, rows, product);
    return product;
  }
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
  for (int group = 0; group < samples.groups(); ++group) {
    const auto& of_group = rows.values[group];
    Lanes value = combination[0] * values_at<Lanes>(of_group[0]);
    for (int k = 1; k < kSaddleParameters; ++k) value += combination[k] * values_at<Lanes>(of_group[k]);
    value *= values_at<Lanes>(samples.root_weight + group * kLanes);
    sums += value * value;
  }
  double sum = 0;
  for (int lane = 0; lane < kLanes; ++lane) sum += sums[lane];
  return sum;
}

}  // namespace raybundle
