// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"

namespace raybundle::testing {

struct RenderOptions {
  int samples = 4;          ///< per pixel and axis
  double blur_px = 0.5;     ///< standard deviation of the lens blur
  double noise_grey = 0.0;  ///< standard deviation of the pixel noise
  double dark = 35;         ///< grey value of ink
  double bright = 205;      ///< grey value of paper
  double background = 90;   ///< grey value beside the board
  unsigned seed = 1;
};

/// Ink on a flat board at (x, y) [m]: 0 dark, 1 bright, below 0 beside the board.
using Print = std::function<double(double, double)>;

/// Squares around columns × rows inner corners, the one outside of corner 0 dark, with a bright border one square wide.
inline Print chessboard_print(int columns, int rows, double square_m) {
  return [=](double x, double y) {
    const int i = static_cast<int>(std::floor(x / square_m)) + 1;  // square's column, 0 to columns
    const int j = static_cast<int>(std::floor(y / square_m)) + 1;
    if (i < -1 || j < -1 || i > columns + 1 || j > rows + 1) return -1.0;
    if (i < 0 || j < 0 || i > columns || j > rows) return 1.0;
    return (i + j) % 2 == 0 ? 0.0 : 1.0;
  };
}

/// 8-bit image of a flat printed board through any camera, supersampled: rays of the pixels' corners, bilinear between.
inline cv::Mat render_board(const Camera& camera, const Rigid3& camera_from_target, const Print& print,
                            const RenderOptions& options = {}) {
  const Rigid3 target_from_camera = camera_from_target.inverse();
  const int width = camera.size.width + 1;
  std::vector<std::optional<Eigen::Vector3d>> ray_in_target(static_cast<std::size_t>(width) * (camera.size.height + 1));
  for (int y = 0; y <= camera.size.height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto ray = ray_from_pixel(camera, {x - 0.5, y - 0.5});
      if (ray) ray_in_target[y * width + x] = target_from_camera.rotation * *ray;
    }
  }
  const Eigen::Vector3d eye = target_from_camera.translation;
  cv::Mat image(camera.size.height, camera.size.width, CV_32F);
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) {
      const auto* corner = &ray_in_target[y * width + x];
      const bool seen = corner[0] && corner[1] && corner[width] && corner[width + 1];
      double sum = 0;
      for (int s = 0; s < options.samples * options.samples; ++s) {
        const double fx = (s % options.samples + 0.5) / options.samples;
        const double fy = (s / options.samples + 0.5) / options.samples;
        double ink = -1;
        if (seen) {
          const Eigen::Vector3d ray = (1 - fy) * ((1 - fx) * *corner[0] + fx * *corner[1]) +
                                      fy * ((1 - fx) * *corner[width] + fx * *corner[width + 1]);
          const double scale = -eye.z() / ray.z();
          if (scale > 0) ink = print(eye.x() + scale * ray.x(), eye.y() + scale * ray.y());
        }
        sum += ink < 0 ? options.background : options.dark + ink * (options.bright - options.dark);
      }
      image.at<float>(y, x) = static_cast<float>(sum / (options.samples * options.samples));
    }
  }
  if (options.blur_px > 0) cv::GaussianBlur(image, image, {}, options.blur_px);
  std::mt19937 random(options.seed);
  std::normal_distribution<float> noise(0, 1);
  cv::Mat grey(image.size(), CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const float value = image.at<float>(y, x) + static_cast<float>(options.noise_grey) * noise(random);
      grey.at<uchar>(y, x) = cv::saturate_cast<uchar>(value);
    }
  }
  return grey;
}

/// Where the corners of a chessboard are, by id, as far as they are in the image.
inline std::vector<std::optional<Eigen::Vector2d>> chessboard_truth(const Camera& camera,
                                                                    const Rigid3& camera_from_target, int columns,
                                                                    int rows, double square_m) {
  std::vector<std::optional<Eigen::Vector2d>> pixels;
  for (int id = 0; id < columns * rows; ++id) {
    auto pixel = pixel_from_ray(
        camera, camera_from_target * Eigen::Vector3d(id % columns * square_m, id / columns * square_m, 0));
    const bool inside = pixel && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < camera.size.width - 1 &&
                        pixel->y() < camera.size.height - 1;
    pixels.push_back(inside ? pixel : std::nullopt);
  }
  return pixels;
}

}  // namespace raybundle::testing
