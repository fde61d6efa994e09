// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_dots_peaks.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "raybundle/geometry/quantile.hpp"

namespace raybundle {
namespace {

bool is_peak(const cv::Mat& response, int x, int y, int radius) {
  const float value = response.at<float>(y, x);
  for (int v = std::max(0, y - radius); v <= std::min(response.rows - 1, y + radius); ++v) {
    const float* row = response.ptr<float>(v);
    for (int u = std::max(0, x - radius); u <= std::min(response.cols - 1, x + radius); ++u) {
      const bool later = v > y || (v == y && u > x);
      if (row[u] > value || (row[u] == value && !later && (u != x || v != y))) return false;
    }
  }
  return true;
}

struct Response {
  cv::Mat matched;
  double kernel_squares = 0.0;  // variance of the response over that of the pixels
  double peak = 0.0;            // of the kernel
};

// Of a spot's matched filter without mean.
Response response_of(const DotImages& images, double sigma_px) {
  // Without a laser-off image the filter must be short, lest printed edges drown what lies beside them.
  const int radius = static_cast<int>(images.pair() ? std::ceil(3 * sigma_px) + 1 : std::ceil(2.5 * sigma_px));
  const int side = 2 * radius + 1;
  const cv::Mat kernel = cv::getGaussianKernel(side, sigma_px, CV_32F);  // sums to 1
  double squares = 0;
  for (int i = 0; i < side; ++i) squares += std::pow(static_cast<double>(kernel.at<float>(i)), 2);
  const double mean = 1.0 / (side * side);
  Response response{{}, squares * squares - mean, std::pow(static_cast<double>(kernel.at<float>(radius)), 2)};
  cv::Mat average;
  cv::sepFilter2D(images.signal, response.matched, CV_32F, kernel, kernel);
  cv::boxFilter(images.signal, average, CV_32F, {side, side});
  cv::subtract(response.matched, average, response.matched);
  return response;
}

}  // namespace

double noise_excess(const DotImages& images, double sigma_px, const cv::Mat& in_region) {
  constexpr std::size_t kFewest = 500;  // pixels
  const Response response = response_of(images, sigma_px);
  std::vector<double> sizes;
  for (int y = 0; y < in_region.rows; ++y) {
    for (int x = 0; x < in_region.cols; ++x) {
      if (in_region.at<unsigned char>(y, x) == 0) continue;
      const double variance = static_cast<double>(images.variance.at<float>(y, x)) * response.kernel_squares;
      sizes.push_back(std::abs(static_cast<double>(response.matched.at<float>(y, x))) / std::sqrt(variance));
    }
  }
  return sizes.size() < kFewest ? 1.0 : median(sizes) / kNormalMedian;
}

std::vector<SpotPeak> spot_peaks(const DotImages& images, double sigma_px, double least_significance) {
  const auto [matched, kernel_squares, peak] = response_of(images, sigma_px);
  std::vector<SpotPeak> peaks;
  const int apart = std::max(1, static_cast<int>(std::lround(sigma_px)));
  const float floor = static_cast<float>(least_significance * least_significance * kernel_squares);
  for (int y = 0; y < matched.rows; ++y) {
    const float *response = matched.ptr<float>(y), *variance = images.variance.ptr<float>(y);
    for (int x = 0; x < matched.cols; ++x) {
      if (response[x] <= 0 || response[x] * response[x] < floor * variance[x]) continue;
      if ((x > 0 && response[x - 1] > response[x]) || (x + 1 < matched.cols && response[x + 1] > response[x])) continue;
      if (!is_peak(matched, x, y, apart)) continue;
      peaks.push_back({{x, y},
                       response[x] / std::sqrt(variance[x] * static_cast<float>(kernel_squares)),
                       static_cast<float>(response[x] * peak / kernel_squares)});
    }
  }
  return peaks;
}

}  // namespace raybundle
