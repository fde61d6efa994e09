// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

namespace raybundle {

/// Side of the square tiles in which large matrices are multiplied: two poses, or three beams.
inline constexpr int kTile = 12;

/// Rows of kTile numbers each of a tile's left and right factor.
struct TileRows {
  const double* left;
  const double* right;
};

/// Row and column, in tiles, of one of the tiles of an upper triangle, which are counted column by column.
struct TilePlace {
  int row;
  int column;
};
TilePlace tile_place(int tile);

/// tile -= Σ leftᵀ right over all `pairs` of `rows` consecutive rows each.
///
/// @param tile    kTile × kTile, column by column
/// @param stride  from column to column
void subtract_products(std::span<const TileRows> pairs, int rows, double* tile, Eigen::Index stride);

}  // namespace raybundle
