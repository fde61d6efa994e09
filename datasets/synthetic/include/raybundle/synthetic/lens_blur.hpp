// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/camera/camera.hpp"

namespace raybundle {

inline constexpr int kCellsPerPixel = 4;  ///< each way: what the light of a scene is sampled in

/// The light of a rectangle of pixels in cells. Cells are stored so that the blur runs over contiguous numbers.
class CellLight {
 public:
  /// @param left, top  the first pixel, may be outside of the image
  CellLight(int left, int top, int width, int height)
      : left_(left),
        top_(top),
        width_(width),
        height_(height),
        values_(static_cast<std::size_t>(width) * height * kCellsPerPixel * kCellsPerPixel) {}

  int left() const { return left_; }
  int top() const { return top_; }
  int width() const { return width_; }  ///< [px]
  int height() const { return height_; }

  /// @param x, y  pixel, as in the image
  /// @param i, j  cell of the pixel, 0 to kCellsPerPixel - 1
  float& at(int x, int y, int i, int j) { return values_[row_start((y - top_) * kCellsPerPixel + j, i) + (x - left_)]; }

  /// Cells number `i` of all pixels of a row of cells.
  const float* row(int cell_row, int i) const { return values_.data() + row_start(cell_row, i); }

 private:
  std::size_t row_start(int cell_row, int i) const {
    return (static_cast<std::size_t>(cell_row) * kCellsPerPixel + i) * width_;
  }

  int left_, top_, width_, height_;
  std::vector<float> values_;
};

/// Light for each pixel of an image, row by row.
struct LightImage {
  ImageSize size;
  std::vector<float> values;

  explicit LightImage(ImageSize image_size)
      : size(image_size), values(static_cast<std::size_t>(image_size.width) * image_size.height) {}
};

/// A lens's Gaussian spot together with the square of a pixel.
class LensBlur {
 public:
  /// @param sigma_px  each axis; 0: a perfect lens
  explicit LensBlur(double sigma_px);

  /// Pixels over which the light of one is spread, to each side.
  int reach() const { return reach_; }

  /// Adds the mean light over each pixel.
  void add(const CellLight& cells, LightImage& image) const;

 private:
  float weight(int cell, int pixels_away) const { return weights_[cell * (2 * reach_ + 1) + pixels_away + reach_]; }

  int reach_;
  std::vector<float> weights_;  ///< of a cell in the pixel that is so far from its own
};

}  // namespace raybundle
