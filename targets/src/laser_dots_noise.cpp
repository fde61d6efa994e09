// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_dots_noise.hpp"

#include <Eigen/Dense>
#include <numeric>
#include <opencv2/core.hpp>
#include <vector>

namespace raybundle {
namespace {

constexpr int kBlock = 8;                         // pixels
constexpr double kQuantisation = 1.0 / 12;        // variance of rounding, grey²
constexpr std::size_t kBins = 16;                 // of grey values
constexpr double kFlatShare = 0.3;                // of a bin's blocks: those with the least structure
constexpr std::size_t kFewestBlocks = 8;          // of a bin
constexpr double kMedianOfBlockVariance = 0.975;  // over the mean, for white noise in a block, by simulation

struct Block {
  double grey = 0;       // of the background
  double variance = 0;   // of the finest detail, which spots and print hardly have
  double structure = 0;  // what is coarser than two pixels, independent of `variance` in white noise
};

// The mixed fourth difference (Immerkaer 1996), whose squares' mean is 36 times the variance of white noise.
double detail(const cv::Mat& image, int top, int left) {
  double sum = 0;
  for (int y = top; y < top + kBlock; ++y) {
    const float* above = image.ptr<float>(y - 1);
    const float* here = image.ptr<float>(y);
    const float* below = image.ptr<float>(y + 1);
    for (int x = left; x < left + kBlock; ++x) {
      const float fourth = above[x - 1] + above[x + 1] + below[x - 1] + below[x + 1] + 4 * here[x] -
                           2 * (above[x] + below[x] + here[x - 1] + here[x + 1]);
      sum += static_cast<double>(fourth * fourth);
    }
  }
  return sum / (36.0 * kBlock * kBlock);
}

double structure(const cv::Mat& image, int top, int left) {
  double sum = 0, squares = 0;
  constexpr int count = kBlock * kBlock / 4;
  for (int y = top; y < top + kBlock; y += 2) {
    const float* upper = image.ptr<float>(y);
    const float* lower = image.ptr<float>(y + 1);
    for (int x = left; x < left + kBlock; x += 2) {
      const double four = upper[x] + upper[x + 1] + lower[x] + lower[x + 1];
      sum += four;
      squares += four * four;
    }
  }
  return squares - sum * sum / count;
}

struct GreyRange {
  double mean = 0;
  float most = 0;
};

GreyRange range_of(const cv::Mat& image, int top, int left) {
  GreyRange range;
  for (int y = top; y < top + kBlock; ++y) {
    const float* row = image.ptr<float>(y);
    for (int x = left; x < left + kBlock; ++x) {
      range.mean += row[x];
      range.most = std::max(range.most, row[x]);
    }
  }
  range.mean /= kBlock * kBlock;
  return range;
}

std::vector<Block> blocks_of(const cv::Mat& difference, const cv::Mat& background, double full_scale) {
  std::vector<Block> blocks;
  for (int y = 1; y + kBlock < difference.rows; y += kBlock) {
    for (int x = 1; x + kBlock < difference.cols; x += kBlock) {
      const GreyRange grey = range_of(background, y, x);
      // Pixels that are black or white altogether have no noise, and say nothing of the others'.
      if (grey.most > 0.98 * full_scale || grey.most <= 0) continue;
      blocks.push_back({grey.mean, detail(difference, y, x), structure(difference, y, x)});
    }
  }
  std::ranges::sort(blocks, {}, &Block::grey);
  return blocks;
}

// Median variance of the flattest blocks.
Block flat_median(std::vector<Block> bin) {
  const std::size_t flat = std::max(std::min(kFewestBlocks, bin.size()),
                                    static_cast<std::size_t>(kFlatShare * static_cast<double>(bin.size())));
  std::ranges::nth_element(bin, bin.begin() + static_cast<std::ptrdiff_t>(flat) - 1, {}, &Block::structure);
  bin.resize(flat);
  Block median;
  for (const Block& block : bin) median.grey += block.grey / static_cast<double>(flat);
  const auto middle = bin.begin() + static_cast<std::ptrdiff_t>(flat / 2);
  std::ranges::nth_element(bin, middle, {}, &Block::variance);
  median.variance = middle->variance / kMedianOfBlockVariance;
  return median;
}

}  // namespace

GreyNoise noise_of(const cv::Mat& on, const cv::Mat& off, double scale, double full_scale) {
  const bool pair = !off.empty();
  cv::Mat difference;
  if (pair) cv::scaleAdd(off, -scale, on, difference);
  const std::vector<Block> blocks = blocks_of(pair ? difference : on, pair ? off : on, full_scale);
  if (blocks.empty()) return {};
  // What one image's read variance and shot variance contribute to the variance of the difference.
  const double read_share = pair ? 1 + scale * scale : 1.0;
  const double shot_share = pair ? scale + scale * scale : 1.0;
  const std::size_t bins = std::clamp<std::size_t>(blocks.size() / (4 * kFewestBlocks), 1, kBins);
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  const auto add = [&](const Eigen::Vector2d& row, double variance, double weight) {
    normal += weight * row * row.transpose();
    right += weight * variance * row;
  };
  for (std::size_t i = 0; i < bins; ++i) {
    const auto from = blocks.begin() + static_cast<std::ptrdiff_t>(blocks.size() * i / bins);
    const auto to = blocks.begin() + static_cast<std::ptrdiff_t>(blocks.size() * (i + 1) / bins);
    const Block median = flat_median({from, to});
    const double variance = std::max(median.variance, kQuantisation * read_share);
    // Relative errors of the bins are alike. A slight pull towards equal shares decides where all greys are the same.
    const Eigen::Vector2d row(read_share, shot_share * std::max(0.0, median.grey));
    add(row, variance, 1 / (variance * variance));
    add({row.x(), 0}, variance / 2, 1e-3 / (variance * variance));
    add({0, row.y()}, variance / 2, 1e-3 / (variance * variance));
  }
  Eigen::Vector2d solution = (normal + 1e-12 * Eigen::Matrix2d::Identity()).ldlt().solve(right);
  if (solution.y() < 0) solution = {right.x() / normal(0, 0), 0};
  if (solution.x() < kQuantisation)
    solution = {kQuantisation, (right.y() - normal(0, 1) * kQuantisation) / normal(1, 1)};
  return {std::max(kQuantisation, solution.x()), std::max(0.0, solution.y())};
}

double background_scale(const cv::Mat& on, const cv::Mat& off, double black, double full_scale) {
  constexpr int step = 3;  // pixels: enough of them
  std::vector<float> greys;
  for (int y = 0; y < off.rows; y += step) {
    for (int x = 0; x < off.cols; x += step) greys.push_back(off.at<float>(y, x));
  }
  const auto middle = greys.begin() + static_cast<std::ptrdiff_t>(greys.size() / 2);
  std::ranges::nth_element(greys, middle);
  const double least = std::max(black + 1.0, static_cast<double>(*middle));
  std::vector<double> ratios;
  for (int y = 0; y < off.rows; y += step) {
    for (int x = 0; x < off.cols; x += step) {
      const double dark = off.at<float>(y, x), bright = on.at<float>(y, x);
      if (dark >= least && std::max(dark, bright) < 0.98 * full_scale)
        ratios.push_back((bright - black) / (dark - black));
    }
  }
  if (ratios.size() < 100) return 1.0;
  std::ranges::sort(ratios);
  // The mean about the median of those within what the lower side's spread, which has no spots, calls a sigma.
  double scale = ratios[ratios.size() / 2];
  for (int pass = 0; pass < 3; ++pass) {
    const auto below = std::ranges::lower_bound(ratios, scale);
    const double sigma =
        scale - *(below - static_cast<std::ptrdiff_t>(0.683 * static_cast<double>(below - ratios.begin())));
    const auto from = std::ranges::lower_bound(ratios, scale - sigma),
               to = std::ranges::upper_bound(ratios, scale + sigma);
    if (from == to) break;
    scale = std::accumulate(from, to, 0.0) / static_cast<double>(to - from);
  }
  return scale;
}

}  // namespace raybundle
