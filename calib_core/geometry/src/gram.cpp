// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/gram.hpp"

#include "raybundle/geometry/target_clones.hpp"

namespace raybundle {
namespace {

// Four rows at once; machines with narrower registers use several.
using Lane = double __attribute__((vector_size(32), aligned(8), may_alias));

// A tile of 4×3 products: as many sums as sixteen registers can hold beside what they add up.
constexpr int kTileRows = 4;
constexpr int kTileColumns = 3;

}  // namespace

RAYBUNDLE_TARGET_CLONES
void gram(const Eigen::MatrixXd& rows, Eigen::MatrixXd& product, int first) {
  const int columns = static_cast<int>(rows.cols()) - first;
  const Eigen::Index stride = rows.rows();
  const double* const begin = rows.data() + first * stride;
  product.resize(columns, columns);
  for (int a = 0; a < columns; a += kTileRows) {
    for (int b = a / kTileColumns * kTileColumns; b < columns; b += kTileColumns) {
      const double* left[kTileRows];
      const double* right[kTileColumns];
      for (int k = 0; k < kTileRows; ++k) left[k] = begin + std::min(a + k, columns - 1) * stride;
      for (int l = 0; l < kTileColumns; ++l) right[l] = begin + std::min(b + l, columns - 1) * stride;
      Lane sum[kTileRows][kTileColumns] = {};
      for (Eigen::Index i = 0; i < stride; i += 4) {
        for (int k = 0; k < kTileRows; ++k) {
          const Lane x = *reinterpret_cast<const Lane*>(left[k] + i);
          for (int l = 0; l < kTileColumns; ++l) sum[k][l] += x * *reinterpret_cast<const Lane*>(right[l] + i);
        }
      }
      for (int k = 0; k < kTileRows; ++k) {
        for (int l = 0; l < kTileColumns; ++l) {
          const Lane& s = sum[k][l];
          if (a + k <= b + l && b + l < columns) product(a + k, b + l) = (s[0] + s[1]) + (s[2] + s[3]);
        }
      }
    }
  }
}

}  // namespace raybundle
