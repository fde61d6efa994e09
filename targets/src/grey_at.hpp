// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace raybundle {

/// Grey value between four pixels, bilinear; -1 outside of the image.
///
/// @param gray  8-bit
inline double grey_at(const cv::Mat& gray, const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(std::floor(pixel.x()));
  const int y = static_cast<int>(std::floor(pixel.y()));
  if (x < 0 || y < 0 || x + 1 >= gray.cols || y + 1 >= gray.rows) return -1.0;
  const double a = pixel.x() - x;
  const double b = pixel.y() - y;
  const auto* top = gray.ptr<std::uint8_t>(y) + x;
  const auto* bottom = gray.ptr<std::uint8_t>(y + 1) + x;
  return (1 - b) * ((1 - a) * top[0] + a * top[1]) + b * ((1 - a) * bottom[0] + a * bottom[1]);
}

}  // namespace raybundle
