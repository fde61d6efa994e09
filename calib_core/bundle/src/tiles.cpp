// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "tiles.hpp"

#include "raybundle/geometry/target_clones.hpp"

namespace raybundle {
namespace {

using Lane = double __attribute__((vector_size(32), aligned(8), may_alias));

// Columns of a tile at once: with three lanes each as many sums as sixteen registers can hold beside what they add up.
constexpr int kColumns = 4;

}  // namespace

TilePlace tile_place(int tile) {
  int column = 0;
  for (; tile > column; ++column) tile -= column + 1;
  return {tile, column};
}

RAYBUNDLE_TARGET_CLONES
void subtract_products(std::span<const TileRows> pairs, int rows, double* tile, Eigen::Index stride) {
  for (int first = 0; first < kTile; first += kColumns) {
    Lane sum[kColumns][3] = {};
    for (const TileRows& pair : pairs) {
      const double* left = pair.left;
      const double* right = pair.right + first;
      for (int k = 0; k < rows; ++k, left += kTile, right += kTile) {
        const Lane a = *reinterpret_cast<const Lane*>(left);
        const Lane b = *reinterpret_cast<const Lane*>(left + 4);
        const Lane c = *reinterpret_cast<const Lane*>(left + 8);
        for (int j = 0; j < kColumns; ++j) {
          sum[j][0] += a * right[j];
          sum[j][1] += b * right[j];
          sum[j][2] += c * right[j];
        }
      }
    }
    for (int j = 0; j < kColumns; ++j) {
      double* column = tile + (first + j) * stride;
      for (int l = 0; l < 3; ++l) *reinterpret_cast<Lane*>(column + 4 * l) -= sum[j][l];
    }
  }
}

}  // namespace raybundle
