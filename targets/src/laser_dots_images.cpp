// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_dots_images.hpp"

#include <opencv2/imgproc.hpp>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr int kSmoothing = 5;  // pixels, of the grey value that tells the noise

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
  off->convertTo(images.background, CV_32F);
  const double scale = background_scale(images.on, images.background, images.black, full);
  images.noise = noise_of(images.on, images.background, scale, full);
  images.background.convertTo(images.background, CV_32F, scale, images.black * (1 - scale));
  cv::subtract(images.on, images.background, images.signal);
  // Of a scaled image the shot noise is `scale` times as strong, the read noise its square.
  cv::boxFilter(images.background, images.variance, CV_32F, {3, 3});
  images.variance.convertTo(images.variance, CV_32F, images.noise.shot_variance * (1 + scale),
                            images.noise.read_variance * (1 + scale * scale));
  return images;
}

}  // namespace raybundle
