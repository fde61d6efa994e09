// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_dots_images.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr int kSmoothing = 5;         // pixels; side of the window in which the laser-off image may be smooth
constexpr double kSureOfPrint = 1.3;  // times the noise's variance, above which a window shows print

void check(const cv::Mat& on, const cv::Mat* off) {
  if (on.empty() || (on.type() != CV_8UC1 && on.type() != CV_16UC1)) {
    throw Error(ErrorKind::kBadInput,
                "dots are looked for in 8-bit or 16-bit images of a single channel: convert this one");
  }
  if (off != nullptr && (off->size() != on.size() || off->type() != on.type())) {
    throw Error(ErrorKind::kBadInput,
                "the images with the laser on and off differ in size or bits: take both with the same settings");
  }
}

// The smallest full scale that holds all values; an image with values left-aligned in 16 bits ends a little below.
double full_scale_of(const cv::Mat& on, const cv::Mat* off) {
  if (on.depth() == CV_8U) return 255;
  double most = 0, most_off = 0;
  cv::minMaxLoc(on, nullptr, &most);
  if (off != nullptr) cv::minMaxLoc(*off, nullptr, &most_off);
  for (const double full : {255.0, 1023.0, 4095.0, 16383.0}) {
    if (std::max(most, most_off) <= full) return full;
  }
  return 65535;
}

// Wiener's filter: keeps of the deviation from the local mean the share that noise does not explain.
void smooth_off(const cv::Mat& off, const GreyNoise& noise, cv::Mat& smooth, cv::Mat& variance) {
  cv::Mat mean, square;
  cv::boxFilter(off, mean, CV_32F, {kSmoothing, kSmoothing});
  cv::sqrBoxFilter(off, square, CV_32F, {kSmoothing, kSmoothing});
  smooth.create(off.size(), CV_32F);
  variance.create(off.size(), CV_32F);
  const float read = static_cast<float>(noise.read_variance), shot = static_cast<float>(noise.shot_variance);
  constexpr float pixels = kSmoothing * kSmoothing;
  for (int y = 0; y < off.rows; ++y) {
    const float *grey = off.ptr<float>(y), *average = mean.ptr<float>(y), *squares = square.ptr<float>(y);
    float *out = smooth.ptr<float>(y), *left = variance.ptr<float>(y);
    for (int x = 0; x < off.cols; ++x) {
      const float expected = read + shot * std::max(0.0F, average[x]);
      const float seen = std::max(squares[x] - average[x] * average[x], 1e-6F);
      const float kept = std::max(0.0F, 1 - static_cast<float>(kSureOfPrint) * expected / seen);
      out[x] = average[x] + kept * (grey[x] - average[x]);
      left[x] = expected * (kept * kept + (1 - kept * kept) / pixels);
    }
  }
}

}  // namespace

DotImages dot_images(const cv::Mat& on, const cv::Mat* off, const DotOptions& options) {
  check(on, off);
  DotImages images;
  images.black = options.black_grey;
  const double full = options.full_scale_grey > 0 ? options.full_scale_grey : full_scale_of(on, off);
  images.full_scale = full * (1 - 1.0 / 1024);
  on.convertTo(images.on, CV_32F);
  if (off == nullptr) {
    images.signal = images.on;
    images.noise = noise_of(images.on, {}, 0, full);
    cv::boxFilter(images.on, images.variance, CV_32F, {kSmoothing, kSmoothing});
    images.variance.convertTo(images.variance, CV_32F, images.noise.shot_variance, images.noise.read_variance);
    return images;
  }
  cv::Mat dark, variance;
  off->convertTo(dark, CV_32F);
  const double scale = background_scale(images.on, dark, images.black, full);
  images.noise = noise_of(images.on, dark, scale, full);
  smooth_off(dark, images.noise, images.background, variance);
  images.background.convertTo(images.background, CV_32F, scale, images.black * (1 - scale));
  cv::subtract(images.on, images.background, images.signal);
  // The laser-off image's own noise, and that of the background it predicts.
  images.variance.create(on.size(), CV_32F);
  for (int y = 0; y < on.rows; ++y) {
    const float *level = images.background.ptr<float>(y), *left = variance.ptr<float>(y);
    float* out = images.variance.ptr<float>(y);
    const float read = static_cast<float>(images.noise.read_variance);
    const float shot = static_cast<float>(images.noise.shot_variance), gain = static_cast<float>(scale * scale);
    for (int x = 0; x < on.cols; ++x) out[x] = read + shot * std::max(0.0F, level[x]) + gain * left[x];
  }
  return images;
}

}  // namespace raybundle
