// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/mat.hpp>
#include <random>
#include <vector>

namespace raybundle::testing {

/// Laser spots on a printed chessboard, warped as by a lens, with noise.
struct SpotScene {
  int width = 640, height = 480;
  int rows = 16, columns = 19;  ///< of the spots
  double snr = 10;              ///< a spot's highest grey value over the noise of its surface, where it lies
  double least_sigma_px = 0.8;  ///< of the whole spot, with lens, without pixel; each frame draws its own
  double most_sigma_px = 2.0;
  double elongation = 1.25;        ///< length over width
  double square_px = 40;           ///< of the print; 0: plain paper
  double paper = 0.9, ink = 0.08;  ///< reflectances
  double paper_grey = 120;         ///< ambient light on paper, for 8 bits
  double read_noise = 1.2;         ///< [grey] for 8 bits
  double shot_per_grey = 0.03;     ///< [grey² per grey] for 8 bits
  int bits = 8;                    ///< above 8: in 16, greys as many times larger
  double off_scale = 1.0;          ///< ambient light of the laser-off image over that of the other
  unsigned seed = 1;
};

struct TrueSpot {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d bound_px2;   ///< Cramér-Rao bound, of amplitude, place and an even background from one image
  double edge_sigmas = 1e9;    ///< distance to the nearest printed edge, in sigmas of the spot
  double border_sigmas = 1e9;  ///< distance to the image's border, in sigmas of the spot
};

struct SpotFrame {
  cv::Mat on, off;
  std::vector<TrueSpot> spots;
  double sigma_px = 0;  ///< of the spots with pixel and lens
};

namespace spot_render {

constexpr int kFine = 4;            // samples per pixel and axis
constexpr double kLensSigma = 0.5;  // pixels: the blur after light has met print
constexpr double kPi = std::numbers::pi;

struct Beam {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d moments;  // of the footprint on the surface, in pixels²
  double amplitude = 0;     // grey values on a reflectance of 1
};

// Image of the print's plane: a barrel-like warp, turned.
inline Eigen::Vector2d print_from_pixel(const SpotScene& scene, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d middle(0.5 * scene.width, 0.5 * scene.height);
  const Eigen::Vector2d d = (pixel - middle) / middle.norm();
  const Eigen::Vector2d bent = d * (1 + 0.25 * d.squaredNorm()) * middle.norm();
  const double turn = 0.2 + 0.1 * (scene.seed % 7);
  return {std::cos(turn) * bent.x() - std::sin(turn) * bent.y(), std::sin(turn) * bent.x() + std::cos(turn) * bent.y()};
}

inline double reflectance_at(const SpotScene& scene, const Eigen::Vector2d& pixel) {
  if (scene.square_px <= 0) return scene.paper;
  const Eigen::Vector2d print = print_from_pixel(scene, pixel) / scene.square_px;
  return (static_cast<int>(std::floor(print.x())) + static_cast<int>(std::floor(print.y()))) % 2 == 0 ? scene.paper
                                                                                                      : scene.ink;
}

// Nearest change of the print around a place, up to a distance.
inline double edge_distance(const SpotScene& scene, const Eigen::Vector2d& pixel, double most) {
  const double here = reflectance_at(scene, pixel);
  for (double radius = 0.25; radius < most; radius += 0.25) {
    for (int i = 0; i < 24; ++i) {
      const double angle = 2 * kPi * i / 24;
      const Eigen::Vector2d there = pixel + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      if (reflectance_at(scene, there) != here) return radius;
    }
  }
  return most;
}

using Fine = cv::Mat_<float>;

inline void blur(Fine& image) {
  const double sigma = kLensSigma * kFine;
  const int radius = static_cast<int>(std::ceil(3.5 * sigma));
  std::vector<float> kernel;
  float sum = 0;
  for (int i = -radius; i <= radius; ++i)
    kernel.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma))));
  for (const float value : kernel) sum += value;
  for (float& value : kernel) value /= sum;
  Fine across(image.size());
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      float value = 0;
      for (int i = -radius; i <= radius; ++i)
        value += kernel[i + radius] * image(y, std::clamp(x + i, 0, image.cols - 1));
      across(y, x) = value;
    }
  }
  for (int y = 0; y < image.rows; ++y) {
    float* out = image.ptr<float>(y);
    std::fill(out, out + image.cols, 0.0F);
    for (int i = -radius; i <= radius; ++i) {
      const float* row = across.ptr<float>(std::clamp(y + i, 0, image.rows - 1));
      for (int x = 0; x < image.cols; ++x) out[x] += kernel[i + radius] * row[x];
    }
  }
}

// Mean grey values of the pixels, without noise.
inline cv::Mat_<float> expose(const SpotScene& scene, const Fine& reflectance, const std::vector<Beam>& beams,
                              double ambient) {
  Fine light(reflectance.size(), static_cast<float>(ambient));
  for (const Beam& beam : beams) {
    const Eigen::Matrix2d precision = beam.moments.inverse();
    const double reach = 5 * std::sqrt(beam.moments.trace());
    const auto fine = [](double at) { return static_cast<int>((at + 0.5) * kFine); };
    for (int y = std::max(0, fine(beam.pixel.y() - reach)); y < std::min(light.rows, fine(beam.pixel.y() + reach));
         ++y) {
      for (int x = std::max(0, fine(beam.pixel.x() - reach)); x < std::min(light.cols, fine(beam.pixel.x() + reach));
           ++x) {
        const Eigen::Vector2d d = Eigen::Vector2d((x + 0.5) / kFine - 0.5, (y + 0.5) / kFine - 0.5) - beam.pixel;
        light(y, x) += static_cast<float>(beam.amplitude * std::exp(-0.5 * d.dot(precision * d)));
      }
    }
  }
  light = light.mul(reflectance);
  blur(light);
  cv::Mat_<float> grey(scene.height, scene.width);
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      float sum = 0;
      for (int i = 0; i < kFine * kFine; ++i) sum += light(y * kFine + i / kFine, x * kFine + i % kFine);
      grey(y, x) = sum / (kFine * kFine);
    }
  }
  return grey;
}

inline double variance_of(const SpotScene& scene, double grey) {
  const double unit = std::exp2(scene.bits - 8);
  return std::pow(scene.read_noise * unit, 2) + scene.shot_per_grey * unit * grey + 1.0 / 12;
}

inline cv::Mat digitise(const SpotScene& scene, const cv::Mat_<float>& grey, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double full = std::exp2(scene.bits) - 1, rounding = 1.0 / 12;
  cv::Mat image(grey.size(), scene.bits > 8 ? CV_16U : CV_8U);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const double sigma = std::sqrt(variance_of(scene, grey(y, x)) - rounding);
      const double value = std::clamp(std::round(grey(y, x) + sigma * normal(random)), 0.0, full);
      if (scene.bits > 8) {
        image.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(value);
      } else {
        image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(value);
      }
    }
  }
  return image;
}

// The shape in the image: the footprint, the lens and the pixel.
inline Eigen::Matrix2d seen_moments(const Beam& beam) {
  return beam.moments + (kLensSigma * kLensSigma + 1.0 / 12) * Eigen::Matrix2d::Identity();
}

// Highest value of a spot in the image, on a reflectance of 1.
inline double seen_peak(const Beam& beam) {
  return beam.amplitude * std::sqrt(beam.moments.determinant() / seen_moments(beam).determinant());
}

// Inverse Fisher information of the place, on an even surface.
inline Eigen::Matrix2d bound_of(const SpotScene& scene, const Beam& beam, double reflectance, double ambient) {
  const Eigen::Matrix2d precision = seen_moments(beam).inverse();
  const double peak = seen_peak(beam) * reflectance;
  const int radius = static_cast<int>(std::ceil(5 / std::sqrt(precision.trace() / 2)));
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  const Eigen::Vector2d middle = beam.pixel.array().round();
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const Eigen::Vector2d d = middle + Eigen::Vector2d(x, y) - beam.pixel;
      const double unit = std::exp(-0.5 * d.dot(precision * d));
      const Eigen::Vector2d slope = peak * unit * (precision * d);
      const Eigen::Vector4d row(unit, slope.x(), slope.y(), 1);
      information += row * row.transpose() / variance_of(scene, ambient * reflectance + peak * unit);
    }
  }
  return information.inverse().block<2, 2>(1, 1);
}

}  // namespace spot_render

/// Fixed seed, same bits.
inline SpotFrame render_spots(const SpotScene& scene) {
  using namespace spot_render;
  std::mt19937_64 random(scene.seed);
  std::uniform_real_distribution<double> uniform;
  SpotFrame frame;
  const double sigma = scene.least_sigma_px + uniform(random) * (scene.most_sigma_px - scene.least_sigma_px);
  frame.sigma_px = std::sqrt(sigma * sigma + 1.0 / 12);
  const double ambient = scene.paper_grey / scene.paper * std::exp2(scene.bits - 8);
  const double angle = kPi * uniform(random);
  const Eigen::Vector2d axis(std::cos(angle), std::sin(angle));
  std::vector<Beam> beams;
  for (int i = 0; i < scene.rows * scene.columns; ++i) {
    const double pitch_x = (scene.width - 30.0) / scene.columns, pitch_y = (scene.height - 30.0) / scene.rows;
    Beam beam;
    beam.pixel = {15 + pitch_x * (i % scene.columns + 0.2 + 0.6 * uniform(random)),
                  15 + pitch_y * (i / scene.columns + 0.2 + 0.6 * uniform(random))};
    // Same area as a round spot, longer along the axis.
    const Eigen::Matrix2d seen = sigma * sigma *
                                 (Eigen::Matrix2d::Identity() / scene.elongation +
                                  (scene.elongation - 1 / scene.elongation) * axis * axis.transpose());
    beam.moments = seen - kLensSigma * kLensSigma * Eigen::Matrix2d::Identity();
    const double reflectance = reflectance_at(scene, beam.pixel);
    beam.amplitude = 1;
    beam.amplitude = scene.snr * std::sqrt(variance_of(scene, ambient * reflectance)) / (seen_peak(beam) * reflectance);
    beams.push_back(beam);
    TrueSpot spot;
    spot.pixel = beam.pixel;
    spot.bound_px2 = bound_of(scene, beam, reflectance, ambient);
    spot.edge_sigmas = edge_distance(scene, beam.pixel, 8 * frame.sigma_px) / frame.sigma_px;
    spot.border_sigmas = std::min({beam.pixel.x(), beam.pixel.y(), scene.width - 1 - beam.pixel.x(),
                                   scene.height - 1 - beam.pixel.y()}) /
                         frame.sigma_px;
    frame.spots.push_back(spot);
  }
  Fine reflectance(scene.height * kFine, scene.width * kFine);
  for (int y = 0; y < reflectance.rows; ++y) {
    for (int x = 0; x < reflectance.cols; ++x) {
      reflectance(y, x) = static_cast<float>(reflectance_at(scene, {(x + 0.5) / kFine - 0.5, (y + 0.5) / kFine - 0.5}));
    }
  }
  frame.on = digitise(scene, expose(scene, reflectance, beams, ambient), random);
  frame.off = digitise(scene, expose(scene, reflectance, {}, ambient * scene.off_scale), random);
  return frame;
}

}  // namespace raybundle::testing
