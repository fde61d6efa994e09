// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <deque>
#include <limits>

#include "lattice.hpp"
#include "raybundle/geometry/target_clones.hpp"

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

float grey_clamped(const cv::Mat& image, const Eigen::Vector2f& pixel) {
  const int x = std::clamp(cvRound(pixel.x()), 0, image.cols - 1);
  const int y = std::clamp(cvRound(pixel.y()), 0, image.rows - 1);
  return static_cast<float>(image.at<uchar>(y, x));
}

/// Candidates as arrays, so that a processor looks at several at once.
struct Places {
  std::vector<float> x, y, a_x, a_y, b_x, b_y;  // place and two of the rays; the others are opposite
  std::vector<std::uint8_t> faces;              // whether this one and the last one looked at may face each other

  explicit Places(const std::vector<SaddleCandidate>& candidates) : faces(candidates.size()) {
    for (const SaddleCandidate& candidate : candidates) {
      x.push_back(candidate.pixel.x());
      y.push_back(candidate.pixel.y());
      a_x.push_back(candidate.rays[0].x());
      a_y.push_back(candidate.rays[0].y());
      b_x.push_back(candidate.rays[1].x());
      b_y.push_back(candidate.rays[1].y());
    }
  }
};

/// Looks at all from `begin` on: a ray of one and a ray of the other kind of the other must run along the way between.
RAYBUNDLE_TARGET_CLONES void look(Places& places, std::size_t from, std::size_t begin) {
  const float from_x = places.x[from], from_y = places.y[from];
  const float from_a_x = places.a_x[from], from_a_y = places.a_y[from];
  const float from_b_x = places.b_x[from], from_b_y = places.b_y[from];
  const float *x = places.x.data(), *y = places.y.data(), *a_x = places.a_x.data(), *a_y = places.a_y.data(),
              *b_x = places.b_x.data(), *b_y = places.b_y.data();
  std::uint8_t* __restrict out = places.faces.data();
  const std::size_t count = places.faces.size();
  for (std::size_t j = begin; j < count; ++j) {
    const float way_x = x[j] - from_x, way_y = y[j] - from_y;
    const float from_a = from_a_x * way_x + from_a_y * way_y, from_b = from_b_x * way_x + from_b_y * way_y;
    const float to_a = a_x[j] * way_x + a_y[j] * way_y, to_b = b_x[j] * way_x + b_y[j] * way_y;
    const float least = kAlong * kAlong * (way_x * way_x + way_y * way_y);
    const float back = 0.999F * least;  // rounding: the last word is nearest_links'
    out[j] = static_cast<std::uint8_t>(((from_a * from_a >= least) & (to_b * to_b >= back)) |
                                       ((from_b * from_b >= least) & (to_a * to_a >= back)));
  }
}

/// The nearest candidate along each ray whose own ray looks back and which an edge joins.
Links nearest_links(const std::vector<SaddleCandidate>& candidates, const cv::Mat& blurred) {
  const int n = static_cast<int>(candidates.size());
  Links links(candidates.size());
  Places places(candidates);
  const float longest = 0.45F * static_cast<float>(std::max(blurred.cols, blurred.rows));
  for (int i = 0; i < n; ++i) {
    look(places, static_cast<std::size_t>(i), static_cast<std::size_t>(i) + 1);
    for (int j = i + 1; j < n; ++j) {
      if (places.faces[j] == 0) continue;
      const Eigen::Vector2f way = candidates[j].pixel - candidates[i].pixel;
      const float distance = way.norm();
      if (distance < 2.5F || distance > longest) continue;
      const float least = kAlong * distance;
      for (int ray = 0; ray < 4; ++ray) {
        if (candidates[i].rays[ray].dot(way) < least) continue;
        for (int back = (ray + 1) % 2; back < 4; back += 2) {  // colours alternate: rays of the other kind look back
          const bool nearer_i = distance < links[i][ray].distance;
          const bool nearer_j = distance < links[j][back].distance;
          if (!nearer_i && !nearer_j) continue;
          if (-candidates[j].rays[back].dot(way) < least) continue;
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
      runs = runs && grey_clamped(image, at + beside * clockwise) - grey_clamped(image, at - beside * clockwise) >
                         least_contrast;
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
