// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace raybundle {

/// A function of one variable and its derivative, at one place.
struct ValueAndSlope {
  double value;
  double slope;
};

/// The x in [low, high] with f(x) = target, for an f that is below the target up to there and above it from there on.
/// Newton, with a bisection wherever a step would leave the bracket.
///
/// @param f      x -> ValueAndSlope
/// @param start  first guess, in [low, high]
template <typename Function>
double solve_increasing(const Function& f, double target, double low, double high, double start) {
  double x = start;
  for (int i = 0; i < 100; ++i) {
    const ValueAndSlope at_x = f(x);
    const double error = at_x.value - target;
    (error > 0 ? high : low) = x;
    double next = x - error / at_x.slope;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double step = std::abs(next - x);
    x = next;
    if (!(step > 1e-15 * std::max(1.0, std::abs(x)))) break;
  }
  return x;
}

/// A polynomial on [0, 1] in Bernstein form: sum of c_i binomial(n, i) v^i (1 - v)^(n - i), n = size - 1.
template <std::size_t size>
using Bernstein = std::array<double, size>;

/// Bernstein form of a0 + a1 u + a2 u² + ... for 0 <= u <= limit, with v = u / limit.
template <std::size_t size>
Bernstein<size> bernstein_to_limit(const std::array<double, size>& a, double limit) {
  Bernstein<size> c{};
  for (std::size_t i = 0; i < size; ++i) {
    double term = 1.0;  // binomial(i, k) / binomial(n, k) * limit^k
    for (std::size_t k = 0; k <= i; ++k) {
      c[i] += term * a[k];
      if (k < i) term *= limit * static_cast<double>(i - k) / static_cast<double>(size - 1 - k);
    }
  }
  return c;
}

/// Bernstein form of (1 - v)^n (a0 + a1 u + a2 u² + ...) for all u >= 0, with v = u / (1 + u): the same signs.
template <std::size_t size>
Bernstein<size> bernstein_to_infinity(const std::array<double, size>& a) {
  Bernstein<size> c{};
  double binomial = 1.0;
  for (std::size_t k = 0; k < size; ++k) {
    c[k] = a[k] / binomial;
    binomial *= static_cast<double>(size - 1 - k) / static_cast<double>(k + 1);
  }
  return c;
}

/// Whether the polynomial is positive all the way; false also when its coefficients do not show it.
template <std::size_t size>
bool all_positive(const Bernstein<size>& c) {
  return std::ranges::all_of(c, [](double x) { return x > 0; });
}

/// Value and derivative of a Bernstein polynomial. Source: de Casteljau's algorithm.
template <std::size_t size>
ValueAndSlope bernstein_at(Bernstein<size> c, double v) {
  for (std::size_t left = size - 1; left > 1; --left) {
    for (std::size_t i = 0; i < left; ++i) c[i] += v * (c[i + 1] - c[i]);
  }
  return {c[0] + v * (c[1] - c[0]), static_cast<double>(size - 1) * (c[1] - c[0])};
}

/// The first v in [low, high] where a Bernstein polynomial on that interval is no longer positive; infinity when it
/// stays positive up to `high`. A zero at `high` itself does not count.
///
/// The control polygon bounds the polynomial, so no root is ever stepped over, however close two of them are; that is
/// what a scan with fixed steps cannot promise. Source: Lane and Riesenfeld, "Bounds on a polynomial", BIT 1981.
template <std::size_t size>
double first_root(const Bernstein<size>& c, double low = 0.0, double high = 1.0, int depth = 0) {
  if (!(c[0] > 0)) return low;
  std::size_t positive = 0;  // coefficients before the first negative one
  while (positive < size && c[positive] >= 0) ++positive;
  if (positive == size) return std::numeric_limits<double>::infinity();
  if (depth == 48) return low;

  if (std::all_of(c.begin() + static_cast<std::ptrdiff_t>(positive), c.end(), [](double x) { return x <= 0; })) {
    const auto negated = [&](double v) {  // one change of sign: exactly one root
      const ValueAndSlope at_v = bernstein_at(c, v);
      return ValueAndSlope{-at_v.value, -at_v.slope};
    };
    return low + (high - low) * solve_increasing(negated, 0.0, 0.0, 1.0, 0.5);
  }

  Bernstein<size> left{};
  Bernstein<size> right = c;
  for (std::size_t i = 0; i < size; ++i) {
    left[i] = right[0];
    for (std::size_t j = 0; j + i + 1 < size; ++j) right[j] = 0.5 * (right[j] + right[j + 1]);
  }
  const double middle = 0.5 * (low + high);
  const double root = first_root(left, low, middle, depth + 1);
  return std::isfinite(root) ? root : first_root(right, middle, high, depth + 1);
}

}  // namespace raybundle
