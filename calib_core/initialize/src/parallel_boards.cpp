// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "parallel_boards.hpp"

#include <algorithm>
#include <complex>

namespace raybundle {
namespace {

using Complex = std::complex<double>;

// Median distance of the pixels from the best similarity of the board, z -> a z + b in the complex plane (least
// squares).
double similarity_misfit_px(const PointsInView& view) {
  const auto board = [&](std::size_t i) { return Complex(view.points[i].x(), view.points[i].y()); };
  const auto pixel = [&](std::size_t i) { return Complex(view.pixels[i].x(), view.pixels[i].y()); };
  const std::size_t count = view.points.size();
  Complex board_mean, pixel_mean;
  for (std::size_t i = 0; i < count; ++i) {
    board_mean += board(i) / static_cast<double>(count);
    pixel_mean += pixel(i) / static_cast<double>(count);
  }
  Complex product;
  double square = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    product += std::conj(board(i) - board_mean) * (pixel(i) - pixel_mean);
    square += std::norm(board(i) - board_mean);
  }
  const Complex a = product / square;
  std::vector<double> distances;
  for (std::size_t i = 0; i < count; ++i) {
    distances.push_back(std::abs(pixel(i) - pixel_mean - a * (board(i) - board_mean)));
  }
  return median(distances);
}

bool flat(const PointsInView& view) {
  return std::ranges::all_of(view.points, [](const Eigen::Vector3d& point) { return point.z() == 0.0; });
}

// Boards of y up are mirrored into the image; a similarity keeps handedness.
PointsInView mirrored(PointsInView view) {
  for (Eigen::Vector3d& point : view.points) point.y() = -point.y();
  return view;
}

}  // namespace

bool all_parallel_to_image(const std::vector<PointsInView>& views, double noise_px) {
  const double limit_px = 2.0 * noise_px + 0.05;  // a tilt of 2° already bends 300 px of board by a pixel
  std::size_t parallel = 0;
  for (const PointsInView& view : views) {
    if (!flat(view)) return false;
    parallel += std::min(similarity_misfit_px(view), similarity_misfit_px(mirrored(view))) <= limit_px;
  }
  return 10 * parallel >= 9 * views.size();
}

}  // namespace raybundle
