// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "raybundle/camera/camera.hpp"

namespace raybundle {

/// Rows that divide an image into squares, as nearly as whole numbers allow, when it has that many columns.
inline int rows_of_square_cells(ImageSize size, int columns) {
  return static_cast<int>(std::max(1L, std::lround(static_cast<double>(columns) * size.height / size.width)));
}

/// Pixel in the middle of a cell of an image that is divided into rows × columns equal ones.
inline Eigen::Vector2d middle_of_cell(ImageSize size, int rows, int columns, int row, int column) {
  return {(column + 0.5) * size.width / columns - 0.5, (row + 0.5) * size.height / rows - 0.5};
}

}  // namespace raybundle
