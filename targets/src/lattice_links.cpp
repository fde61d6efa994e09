// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "lattice.hpp"

namespace raybundle {
namespace {

constexpr float kAlong = 0.93F;  // cosine between an edge at the corner and the way to the neighbour: bent rows

/// The neighbour seen along one ray, and the neighbour's ray that looks back.
struct Link {
  int candidate = -1;
  int ray = -1;
  float distance = std::numeric_limits<float>::max();
};
using Links = std::vector<std::array<Link, 4>>;

float grey_at(const cv::Mat& image, const Eigen::Vector2f& pixel) {
  const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, image.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, image.rows - 1);
  return static_cast<float>(image.at<uchar>(y, x));
}

/// The nearest candidate along each ray whose own ray looks back and which an edge joins.
Links nearest_links(const std::vector<SaddleCandidate>& candidates, const cv::Mat& blurred) {
  const int n = static_cast<int>(candidates.size());
  Links links(candidates.size());
  const float longest = 0.45F * static_cast<float>(std::max(blurred.cols, blurred.rows));
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      const Eigen::Vector2f way = candidates[j].pixel - candidates[i].pixel;
      // Most pairs end here; the other two rays look the opposite way.
      const float squared = way.squaredNorm(), along_a = candidates[i].rays[0].dot(way);
      const float along_b = candidates[i].rays[1].dot(way);
      if (std::max(along_a * along_a, along_b * along_b) < kAlong * kAlong * squared) continue;
      const float distance = std::sqrt(squared);
      if (distance < 2.5F || distance > longest) continue;
      const float least = kAlong * distance;
      for (int ray = 0; ray < 4; ++ray) {
        if (candidates[i].rays[ray].dot(way) < least) continue;
        for (int back = (ray + 1) % 2; back < 4; back += 2) {  // colours alternate: rays of the other kind look back
          if (-candidates[j].rays[back].dot(way) < least) continue;
          const bool nearer_i = distance < links[i][ray].distance;
          const bool nearer_j = distance < links[j][back].distance;
          if (!nearer_i && !nearer_j) continue;
          const float contrast = std::min(candidates[i].contrast, candidates[j].contrast);
          if (!edge_between(blurred, candidates[i].pixel, candidates[j].pixel, ray % 2 == 0, 0.25F * contrast))
            continue;
          if (nearer_i) links[i][ray] = {j, back, distance};
          if (nearer_j) links[j][back] = {i, ray, distance};
        }
      }
    }
  }
  return links;
}

bool mutual(const Links& links, int candidate, int ray) {
  const Link& link = links[candidate][ray];
  return link.candidate >= 0 && links[link.candidate][link.ray].candidate == candidate &&
         links[link.candidate][link.ray].ray == ray;
}

Saddle saddle_of(const SaddleCandidate& candidate) {
  Saddle saddle;
  saddle.pixel = candidate.pixel.cast<double>();
  saddle.edge_a = candidate.rays[0].cast<double>();
  saddle.edge_b = candidate.rays[1].cast<double>();
  saddle.contrast = candidate.contrast;
  return saddle;
}

/// Walks the links from a seed; each corner's first place counts.
Lattice walked(const std::vector<SaddleCandidate>& candidates, const Links& links, int seed, std::vector<char>& used) {
  struct Step {
    int candidate;
    int column, row;
    int x_ray;  // the ray that points to larger columns
  };
  static constexpr int kColumn[] = {1, 0, -1, 0};
  static constexpr int kRow[] = {0, 1, 0, -1};
  Lattice lattice;
  std::deque<Step> open{{seed, 0, 0, 0}};
  used[seed] = 1;
  while (!open.empty()) {
    const Step step = open.front();
    open.pop_front();
    if (!lattice.emplace(LatticePlace(step.column, step.row), saddle_of(candidates[step.candidate])).second) continue;
    for (int side = 0; side < 4; ++side) {
      const int ray = (step.x_ray + side) % 4;
      if (!mutual(links, step.candidate, ray)) continue;
      const Link& link = links[step.candidate][ray];
      if (used[link.candidate]) continue;
      used[link.candidate] = 1;
      open.push_back({link.candidate, step.column + kColumn[side], step.row + kRow[side], (link.ray + 6 - side) % 4});
    }
  }
  return lattice;
}

}  // namespace

LatticeExtent extent_of(const Lattice& lattice) {
  if (lattice.empty()) return {};
  const auto [x, y] = lattice.begin()->first;
  LatticeExtent extent{x, x, y, y};
  for (const auto& [place, saddle] : lattice) {
    extent.low_x = std::min(extent.low_x, place.first);
    extent.high_x = std::max(extent.high_x, place.first);
    extent.low_y = std::min(extent.low_y, place.second);
    extent.high_y = std::max(extent.high_y, place.second);
  }
  return extent;
}

bool edge_between(const cv::Mat& image, const Eigen::Vector2f& from, const Eigen::Vector2f& to, bool bright_clockwise,
                  float least_contrast) {
  const Eigen::Vector2f along = to - from;
  const float length = along.norm();
  Eigen::Vector2f clockwise = Eigen::Vector2f(-along.y(), along.x()) / length;
  if (!bright_clockwise) clockwise = -clockwise;
  for (const float beside : {std::clamp(0.2F * length, 1.0F, 2.0F), std::max(1.0F, 0.2F * length)}) {
    bool runs = true;
    for (const float part : {0.3F, 0.4F, 0.5F, 0.6F, 0.7F}) {
      const Eigen::Vector2f at = from + part * along;
      runs = runs && grey_at(image, at + beside * clockwise) - grey_at(image, at - beside * clockwise) > least_contrast;
    }
    if (runs) return true;
  }
  return false;
}

std::vector<Lattice> linked_lattices(const std::vector<SaddleCandidate>& candidates, const cv::Mat& blurred) {
  constexpr std::size_t kSmallest = 6;
  const Links links = nearest_links(candidates, blurred);
  std::vector<char> used(candidates.size(), 0);
  std::vector<Lattice> lattices;
  // Corners with links on all sides make the best seeds: the walk's directions are sure from the start.
  for (int least = 4; least >= 2; --least) {
    for (int seed = 0; seed < static_cast<int>(candidates.size()); ++seed) {
      if (used[seed]) continue;
      int sides = 0;
      for (int ray = 0; ray < 4; ++ray) sides += mutual(links, seed, ray);
      if (sides < least) continue;
      Lattice lattice = walked(candidates, links, seed, used);
      if (lattice.size() >= kSmallest) lattices.push_back(std::move(lattice));
    }
  }
  std::ranges::stable_sort(lattices, std::greater<>(), &Lattice::size);
  return lattices;
}

}  // namespace raybundle
