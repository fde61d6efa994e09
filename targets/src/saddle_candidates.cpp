// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "saddle_candidates.hpp"

#include <algorithm>
#include <cmath>

#include "saddle.hpp"

namespace raybundle {
namespace {

constexpr int kMargin = 4;
constexpr std::size_t kMostCandidates = 1200;  // bounds the search for links, which looks at pairs

/// Minus the Hessian's determinant, from second differences over two pixels: large at saddles, 0 along edges and below
/// at blobs.
void saddle_strength(const cv::Mat& blurred, cv::Mat& strength) {
  strength.create(blurred.size(), CV_32F);
  strength.setTo(0);
  for (int y = 2; y < blurred.rows - 2; ++y) {
    const uchar* above = blurred.ptr<uchar>(y - 2);
    const uchar* here = blurred.ptr<uchar>(y);
    const uchar* below = blurred.ptr<uchar>(y + 2);
    float* out = strength.ptr<float>(y);
    for (int x = 2; x < blurred.cols - 2; ++x) {
      const int xx = here[x - 2] + here[x + 2] - 2 * here[x];
      const int yy = above[x] + below[x] - 2 * here[x];
      const int xy4 = above[x - 2] + below[x + 2] - above[x + 2] - below[x - 2];
      out[x] = static_cast<float>(xy4 * xy4) * 0.0625F - static_cast<float>(xx * yy);
    }
  }
}

bool is_peak(const cv::Mat& strength, int x, int y) {
  const float value = strength.at<float>(y, x);
  for (int dy = -2; dy <= 2; ++dy) {
    const float* row = strength.ptr<float>(y + dy) + x;
    for (int dx = -2; dx <= 2; ++dx) {
      const bool later = dy > 0 || (dy == 0 && dx > 0);
      if (row[dx] > value || (row[dx] == value && !later && (dx != 0 || dy != 0))) return false;
    }
  }
  return true;
}

/// Stationary point of the quadric through the neighbourhood; the pixel itself when that lies elsewhere.
Eigen::Vector2d stationary_point(const cv::Mat& blurred, int x, int y) {
  const auto at = [&](int dx, int dy) { return static_cast<double>(blurred.at<uchar>(y + dy, x + dx)); };
  const double gx = (at(2, 0) - at(-2, 0)) / 4;
  const double gy = (at(0, 2) - at(0, -2)) / 4;
  const double xx = (at(2, 0) + at(-2, 0) - 2 * at(0, 0)) / 4;
  const double yy = (at(0, 2) + at(0, -2) - 2 * at(0, 0)) / 4;
  const double xy = (at(2, 2) + at(-2, -2) - at(2, -2) - at(-2, 2)) / 16;
  const double determinant = xx * yy - xy * xy;
  Eigen::Vector2d pixel(x, y);
  if (determinant > -1e-6) return pixel;
  const Eigen::Vector2d move((-yy * gx + xy * gy) / determinant, (xy * gx - xx * gy) / determinant);
  return move.cwiseAbs().maxCoeff() < 1.5 ? pixel + move : pixel;
}

}  // namespace

std::vector<SaddleCandidate> saddle_candidates(const cv::Mat& blurred) {
  constexpr float kWeakest = 12;  // a corner of some 12 grey values' contrast
  cv::Mat strength;
  saddle_strength(blurred, strength);
  std::vector<std::pair<float, SaddleCandidate>> found;
  for (int y = kMargin; y < blurred.rows - kMargin; ++y) {
    const float* row = strength.ptr<float>(y);
    for (int x = kMargin; x < blurred.cols - kMargin; ++x) {
      if (row[x] < kWeakest || row[x] < row[x - 1] || row[x] < row[x + 1] || !is_peak(strength, x, y)) continue;
      const Eigen::Vector2d pixel = stationary_point(blurred, x, y);
      std::optional<SaddleRing> ring;
      for (const double radius : {4.0, 2.5}) {
        if ((ring = saddle_ring(blurred, pixel, radius))) break;
      }
      if (!ring) continue;
      SaddleCandidate candidate;
      candidate.pixel = pixel.cast<float>();
      const Eigen::Vector2d a(std::cos(ring->angle_a), std::sin(ring->angle_a));
      const Eigen::Vector2d b(std::cos(ring->angle_b), std::sin(ring->angle_b));
      candidate.rays = {a.cast<float>(), b.cast<float>(), -a.cast<float>(), -b.cast<float>()};
      candidate.contrast = static_cast<float>(ring->contrast);
      found.emplace_back(row[x], candidate);
    }
  }
  std::ranges::stable_sort(found, std::greater<>(), &std::pair<float, SaddleCandidate>::first);
  if (found.size() > kMostCandidates) found.resize(kMostCandidates);
  std::vector<SaddleCandidate> candidates;
  candidates.reserve(found.size());
  for (auto& entry : found) candidates.push_back(entry.second);
  return candidates;
}

}  // namespace raybundle
