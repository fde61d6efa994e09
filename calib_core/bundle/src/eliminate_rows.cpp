// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "eliminate_rows.hpp"

#include <Eigen/Cholesky>
#include <vector>

#include "tiles.hpp"

namespace raybundle {
namespace {

constexpr int kRows = 48;  // at once: their part of a tile stays in the first cache

using Panel = Eigen::Matrix<double, Eigen::Dynamic, kTile, Eigen::RowMajor>;

}  // namespace

bool eliminate_rows(Eigen::MatrixXd& matrix, int count, int columns, Workers& workers) {
  std::vector<double> packed;  // the rows behind the diagonal block, in panels of kTile columns
  for (int first = 0; first < count; first += kRows) {
    const int rows = std::min(kRows, count - first);
    Eigen::Ref<Eigen::MatrixXd> corner = matrix.block(first, first, rows, rows);
    if (Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Upper>(corner).info() != Eigen::Success) return false;
    const int next = first + rows;
    const int panels = (columns - next + kTile - 1) / kTile;
    const auto panel_size = static_cast<std::size_t>(rows * kTile);
    packed.resize(panels * panel_size);
    workers.for_each(panels, [&](int p) {
      auto behind = matrix.block(first, next + p * kTile, rows, kTile);
      corner.triangularView<Eigen::Upper>().transpose().solveInPlace(behind);
      Eigen::Map<Panel>(packed.data() + p * panel_size, rows, kTile) = behind;
    });
    workers.for_each(panels * (panels + 1) / 2, [&](int tile) {
      const TilePlace place = tile_place(tile);
      const TileRows pair{packed.data() + place.row * panel_size, packed.data() + place.column * panel_size};
      subtract_products({&pair, 1}, rows, &matrix(next + place.row * kTile, next + place.column * kTile),
                        matrix.rows());
    });
  }
  return true;
}

}  // namespace raybundle
