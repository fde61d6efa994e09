// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "saddle_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "raybundle/geometry/target_clones.hpp"
#include "saddle.hpp"

namespace raybundle {
namespace {

constexpr int kMargin = 4;
constexpr std::size_t kMostCandidates = 1200;  // bounds the search for links, which looks at pairs

/// Minus the Hessian's determinant, from second differences over two pixels: large at saddles, 0 along edges and below
/// at blobs.
RAYBUNDLE_TARGET_CLONES void saddle_strength(const cv::Mat& blurred, cv::Mat& strength) {
  strength.create(blurred.size(), CV_32F);
  strength.setTo(0);
  for (int y = 2; y < blurred.rows - 2; ++y) {
    const uchar* above = blurred.ptr<uchar>(y - 2);
    const uchar* here = blurred.ptr<uchar>(y);
    const uchar* below = blurred.ptr<uchar>(y + 2);
    float* __restrict out = strength.ptr<float>(y);
    const int end = blurred.cols - 2;
    for (int x = 2; x < end; ++x) {
      const auto xx = static_cast<float>(here[x - 2] + here[x + 2] - 2 * here[x]);
      const auto yy = static_cast<float>(above[x] + below[x] - 2 * here[x]);
      const auto xy4 = static_cast<float>(above[x - 2] + below[x + 2] - above[x + 2] - below[x - 2]);
      out[x] = xy4 * xy4 * 0.0625F - xx * yy;
    }
  }
}

/// Marks where a row is at least `weakest` and nowhere below its four neighbours: most of the image is not.
RAYBUNDLE_TARGET_CLONES void mark_high(const cv::Mat& strength, int y, float weakest, std::vector<std::uint8_t>& high) {
  const float *above = strength.ptr<float>(y - 1), *here = strength.ptr<float>(y), *below = strength.ptr<float>(y + 1);
  std::uint8_t* __restrict out = high.data();
  const int end = strength.cols - kMargin;
  for (int x = kMargin; x < end; ++x) {
    out[x] = static_cast<std::uint8_t>((here[x] >= weakest) & (here[x] >= here[x - 1]) & (here[x] >= here[x + 1]) &
                                       (here[x] >= above[x]) & (here[x] >= below[x]));
  }
}

const std::uint8_t* next_marked(const std::uint8_t* from, const std::uint8_t* end) {
  return static_cast<const std::uint8_t*>(std::memchr(from, 1, static_cast<std::size_t>(end - from)));
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

/// Saddle point of the quadric through the neighbourhood; nothing when that lies elsewhere, as on edges.
std::optional<Eigen::Vector2d> stationary_point(const cv::Mat& blurred, int x, int y) {
  const auto at = [&](int dx, int dy) { return static_cast<double>(blurred.at<uchar>(y + dy, x + dx)); };
  const double gx = (at(2, 0) - at(-2, 0)) / 4;
  const double gy = (at(0, 2) - at(0, -2)) / 4;
  const double xx = (at(2, 0) + at(-2, 0) - 2 * at(0, 0)) / 4;
  const double yy = (at(0, 2) + at(0, -2) - 2 * at(0, 0)) / 4;
  const double xy = (at(2, 2) + at(-2, -2) - at(2, -2) - at(-2, 2)) / 16;
  const double determinant = xx * yy - xy * xy;  // below 0 where the strength is above it
  const Eigen::Vector2d move((-yy * gx + xy * gy) / determinant, (xy * gx - xx * gy) / determinant);
  constexpr double kFarthest_px = 1.5;
  if (move.cwiseAbs().maxCoeff() > kFarthest_px) return std::nullopt;
  return Eigen::Vector2d(x, y) + move;
}

}  // namespace

std::vector<SaddleCandidate> saddle_candidates(const cv::Mat& blurred) {
  constexpr float kWeakest = 12;  // a corner of some 12 grey values' contrast
  cv::Mat strength;
  saddle_strength(blurred, strength);
  std::vector<std::pair<float, SaddleCandidate>> found;
  std::vector<std::uint8_t> high(static_cast<std::size_t>(blurred.cols), 0);
  for (int y = kMargin; y < blurred.rows - kMargin; ++y) {
    mark_high(strength, y, kWeakest, high);
    const std::uint8_t *at = high.data(), *const end = at + high.size();
    for (; (at = next_marked(at, end)) != nullptr; ++at) {
      const int x = static_cast<int>(at - high.data());
      if (!is_peak(strength, x, y)) continue;
      const auto pixel = stationary_point(blurred, x, y);
      if (!pixel) continue;
      std::optional<SaddleRing> ring;
      for (const double radius : {4.0, 2.5}) {
        if ((ring = saddle_ring(blurred, *pixel, radius))) break;
      }
      if (!ring) continue;
      SaddleCandidate candidate;
      candidate.pixel = pixel->cast<float>();
      const Eigen::Vector2d a(std::cos(ring->angle_a), std::sin(ring->angle_a));
      const Eigen::Vector2d b(std::cos(ring->angle_b), std::sin(ring->angle_b));
      candidate.rays = {a.cast<float>(), b.cast<float>(), -a.cast<float>(), -b.cast<float>()};
      candidate.contrast = static_cast<float>(ring->contrast);
      found.emplace_back(strength.at<float>(y, x), candidate);
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
