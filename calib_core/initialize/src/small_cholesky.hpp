// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <utility>

namespace raybundle {

/// Cholesky factor of a small symmetric matrix, L Lᵀ. A start factorises thousands of matrices of six or nine rows, on
/// which Eigen, whose loops do not know that they are short, spends most of its time beside the arithmetic.
template <int n>
class SmallCholesky {
 public:
  using Matrix = Eigen::Matrix<double, n, n>;
  using Vector = Eigen::Matrix<double, n, 1>;

  /// Reads the lower triangle.
  explicit SmallCholesky(const Matrix& symmetric) : factor_(symmetric) {
    for_columns([&]<int k>() {
      const double pivot = factor_(k, k);
      positive_ = positive_ && pivot > 0.0;
      inverse_diagonal_[k] = 1.0 / std::sqrt(pivot);
      for (int i = k + 1; i < n; ++i) factor_(i, k) *= inverse_diagonal_[k];
      for_columns([&]<int j>() {
        if constexpr (j > k) {
          for (int i = j; i < n; ++i) factor_(i, j) -= factor_(i, k) * factor_(j, k);
        }
      });
    });
  }

  /// Whether the matrix is positive; what is solved with one that is not has no meaning.
  bool positive() const { return positive_; }

  /// L⁻¹ right.
  Vector half_solved(Vector right) const {
    for_columns([&]<int k>() {
      right[k] *= inverse_diagonal_[k];
      for (int i = k + 1; i < n; ++i) right[i] -= factor_(i, k) * right[k];
    });
    return right;
  }

  /// The other half: L⁻ᵀ half.
  Vector solved(Vector half) const {
    for_columns([&]<int from_last>() {
      constexpr int k = n - 1 - from_last;
      for (int i = k + 1; i < n; ++i) half[k] -= factor_(i, k) * half[i];
      half[k] *= inverse_diagonal_[k];
    });
    return half;
  }

  Vector solve(const Vector& right) const { return solved(half_solved(right)); }

 private:
  /// Calls function.operator()<k>() for the constants 0 to n - 1.
  template <typename Function>
  [[gnu::always_inline]] static void for_columns(const Function& function) {
    [&]<int... k>(std::integer_sequence<int, k...>) { (function.template operator()<k>(), ...); }
    (std::make_integer_sequence<int, n>{});
  }

  Matrix factor_;  ///< below the diagonal
  Vector inverse_diagonal_;
  bool positive_ = true;
};

}  // namespace raybundle
