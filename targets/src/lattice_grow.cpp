// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "lattice.hpp"

namespace raybundle {
namespace {

constexpr std::array<LatticePlace, 4> kSides{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

LatticePlace moved(LatticePlace place, LatticePlace by, int times = 1) {
  return {place.first + times * by.first, place.second + times * by.second};
}

const Eigen::Vector2d* pixel_at(const Lattice& lattice, LatticePlace place) {
  const auto found = lattice.find(place);
  return found == lattice.end() ? nullptr : &found->second.pixel;
}

/// Step and curvature of the lattice line through a corner.
struct Line {
  Eigen::Vector2d step;  // towards larger column or row; the shorter of the two sides' lengths
  double bend = 0;
};

double bend_of(const Eigen::Vector2d& before, const Eigen::Vector2d& at, const Eigen::Vector2d& after) {
  const Eigen::Vector2d chord = 0.5 * (after - before);
  const Eigen::Vector2d second = before + after - 2 * at;
  const double length = chord.norm();
  return (chord.x() * second.y() - chord.y() * second.x()) / (length * length * length);
}

std::optional<Line> line_through(const Lattice& lattice, LatticePlace place, const Eigen::Vector2d& at,
                                 LatticePlace side) {
  const Eigen::Vector2d* after = pixel_at(lattice, moved(place, side));
  const Eigen::Vector2d* before = pixel_at(lattice, moved(place, side, -1));
  Line line;
  if (after && before) {
    const double length = std::min((*after - at).norm(), (at - *before).norm());
    line.step = (*after - *before).normalized() * length;
    line.bend = bend_of(*before, at, *after);
    return line;
  }
  const bool forward = after != nullptr;
  const Eigen::Vector2d* next = forward ? after : before;
  if (!next) return std::nullopt;
  const Eigen::Vector2d* second = pixel_at(lattice, moved(place, side, forward ? 2 : -2));
  line.step = forward ? Eigen::Vector2d(*next - at) : Eigen::Vector2d(at - *next);
  if (!second) return line;
  // At the end of a line: bend as at the neighbour, and the tangent turned from the chord by half a step's bend. The
  // missing next step is as much shorter than this one as this one is than the last.
  line.bend = forward ? bend_of(at, *next, *second) : bend_of(*second, *next, at);
  const double length = line.step.norm();
  const double turn = 0.5 * line.bend * length * (forward ? -1 : 1);
  const Eigen::Matrix2d rotation{{std::cos(turn), -std::sin(turn)}, {std::sin(turn), std::cos(turn)}};
  const double ratio = std::clamp(length / std::max(1e-6, (*second - *next).norm()), 0.5, 1.0);
  line.step = ratio * (rotation * line.step);
  return line;
}

std::optional<Eigen::Vector2d> step_anywhere_near(const Lattice& lattice, LatticePlace place, LatticePlace side) {
  const LatticePlace across{side.second, side.first};
  for (const int away : {1, -1, 2, -2}) {
    const LatticePlace near = moved(place, across, away);
    const Eigen::Vector2d* at = pixel_at(lattice, near);
    if (!at) continue;
    if (const auto line = line_through(lattice, near, *at, side)) return line->step;
  }
  return std::nullopt;
}

/// True when the saddle's bright sectors are where the lattice has its bright squares, and its edges run along it.
bool fits_lattice(const Saddle& saddle, LatticePlace place, const Eigen::Vector2d& half_x,
                  const Eigen::Vector2d& half_y) {
  const Eigen::Vector2d x = half_x.normalized();
  const Eigen::Vector2d y = half_y.normalized();
  const bool even = (place.first + place.second) % 2 == 0;
  // Clockwise from edge_a to edge_b is bright; clockwise from x to y is bright at even places.
  const Eigen::Vector2d along_x = even ? saddle.edge_a : saddle.edge_b;
  const Eigen::Vector2d along_y = even ? saddle.edge_b : saddle.edge_a;
  constexpr double kAligned = 0.85;
  const double cosine_x = along_x.dot(x);
  const double cosine_y = along_y.dot(y);
  if (std::abs(cosine_x) < kAligned || std::abs(cosine_y) < kAligned) return false;
  return (cosine_x * cosine_y > 0) == even;
}

double typical_contrast(const Lattice& lattice, LatticePlace place) {
  std::vector<double> contrasts;
  for (int dx = -2; dx <= 2; ++dx) {
    for (int dy = -2; dy <= 2; ++dy) {
      const auto found = lattice.find(moved(place, {dx, dy}));
      if (found != lattice.end() && (dx != 0 || dy != 0)) contrasts.push_back(found->second.contrast);
    }
  }
  if (contrasts.empty()) return 0;
  std::ranges::nth_element(contrasts, contrasts.begin() + contrasts.size() / 2);
  return contrasts[contrasts.size() / 2];
}

/// Refines every corner against the present lattice and drops the ones that fail.
///
/// @param rough  corners come from candidates, and will be refined again; otherwise they come from fits
void refine_all(const cv::Mat& gray, Lattice& lattice, bool rough) {
  Lattice refined;
  for (const auto& [place, saddle] : lattice) {
    const Saddle* known = rough ? nullptr : &saddle;
    if (const auto better = refined_on_lattice(gray, lattice, place, saddle.pixel, rough, known))
      refined.emplace(place, *better);
  }
  lattice = std::move(refined);
}

/// Drops corners that no edges join to most of their neighbours: chance saddles where the board's border meets things.
void drop_unsupported(const cv::Mat& gray, Lattice& lattice) {
  constexpr double kPart = 0.25;  // of the fainter corner's contrast
  for (int round = 0; round < 3; ++round) {
    std::vector<LatticePlace> unsupported;
    for (const auto& [place, saddle] : lattice) {
      int joined = 0, apart = 0;
      for (int side = 0; side < 4; ++side) {
        const auto next = lattice.find(moved(place, kSides[side]));
        if (next == lattice.end()) continue;
        // Clockwise of the way to larger x is bright at even places, to larger y at odd ones, and so on around.
        const bool bright = (place.first + place.second + side) % 2 == 0;
        const float least = static_cast<float>(kPart * std::min(saddle.contrast, next->second.contrast));
        const bool edge =
            edge_between(gray, saddle.pixel.cast<float>(), next->second.pixel.cast<float>(), bright, least);
        (edge ? joined : apart) += 1;
      }
      if (joined <= apart) unsupported.push_back(place);
    }
    if (unsupported.empty()) return;
    for (const LatticePlace& place : unsupported) lattice.erase(place);
  }
}

/// Drops corners that lie off the place their neighbours give by much more than is usual on this lattice.
void drop_outliers(Lattice& lattice) {
  constexpr double kWorst = 0.2;  // of the shorter step
  for (int round = 0; round < 10; ++round) {
    double worst = kWorst;
    std::optional<LatticePlace> worst_place;
    for (const auto& [place, saddle] : lattice) {
      const auto expected = predicted_on_lattice(lattice, place);
      const auto window = window_on_lattice(lattice, place, saddle.pixel);
      if (!expected || !window) continue;
      const double step = std::min(window->half_x.norm(), window->half_y.norm()) / 0.7;
      const double off = (*expected - saddle.pixel).norm() / step;
      if (off > worst) {
        worst = off;
        worst_place = place;
      }
    }
    if (!worst_place) return;
    lattice.erase(*worst_place);
  }
}

}  // namespace

std::optional<SaddleWindow> window_on_lattice(const Lattice& lattice, LatticePlace place, const Eigen::Vector2d& at) {
  constexpr double kClear = 0.7;  // of a step: keeps the neighbours' edges out of the window
  const auto along_x = line_through(lattice, place, at, {1, 0});
  const auto along_y = line_through(lattice, place, at, {0, 1});
  SaddleWindow window;
  const auto step_x = along_x ? std::optional(along_x->step) : step_anywhere_near(lattice, place, {1, 0});
  const auto step_y = along_y ? std::optional(along_y->step) : step_anywhere_near(lattice, place, {0, 1});
  if (!step_x || !step_y) return std::nullopt;
  window.half_x = kClear * *step_x;
  window.half_y = kClear * *step_y;
  window.bend_x = along_x ? along_x->bend : 0;
  window.bend_y = along_y ? along_y->bend : 0;
  return window;
}

std::optional<Eigen::Vector2d> predicted_on_lattice(const Lattice& lattice, LatticePlace place) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weights = 0;
  const auto add = [&](const Eigen::Vector2d& pixel, double weight) {
    sum += weight * pixel;
    weights += weight;
  };
  for (const LatticePlace& side : kSides) {
    const auto at = [&](int times) { return pixel_at(lattice, moved(place, side, times)); };
    const Eigen::Vector2d* one = at(1);
    const Eigen::Vector2d* two = at(2);
    const Eigen::Vector2d* three = at(3);
    const Eigen::Vector2d* back = at(-1);
    if (one && back) {
      if (two && at(-2)) {
        add((4 * (*one + *back) - *two - *at(-2)) / 6, 20);
      } else if (two) {
        add(*one + *back / 3 - *two / 3, 10);
      } else {
        add(0.5 * (*one + *back), 3);
      }
    } else if (one && two && three) {
      add(3 * *one - 3 * *two + *three, 2);
    } else if (one && two) {
      add(2 * *one - *two, 0.5);
    }
  }
  for (int corner = 0; corner < 4 && weights < 2; ++corner) {
    const LatticePlace side = kSides[corner];
    const LatticePlace across = kSides[(corner + 1) % 4];
    const Eigen::Vector2d* a = pixel_at(lattice, moved(place, side));
    const Eigen::Vector2d* b = pixel_at(lattice, moved(place, across));
    const Eigen::Vector2d* diagonal = pixel_at(lattice, moved(moved(place, side), across));
    if (a && b && diagonal) add(*a + *b - *diagonal, 0.5);
  }
  if (weights < 0.4) return std::nullopt;
  return sum / weights;
}

std::optional<Saddle> refined_on_lattice(const cv::Mat& gray, const Lattice& lattice, LatticePlace place,
                                         const Eigen::Vector2d& start, bool rough, const Saddle* known) {
  auto window = window_on_lattice(lattice, place, start);
  if (!window) return std::nullopt;
  window->rough = rough;
  window->known = known;
  window->doubtful = known == nullptr;
  auto saddle = refine_saddle(gray, start, *window);
  if (!saddle || !fits_lattice(*saddle, place, window->half_x, window->half_y)) return std::nullopt;
  constexpr double kFaintest = 0.2;                              // of the contrast nearby
  const bool may_be_faint = saddle->contrast < kFaintest * 255;  // of 8 bits none has more contrast
  if (may_be_faint && saddle->contrast < kFaintest * typical_contrast(lattice, place)) return std::nullopt;
  return saddle;
}

void grow_lattice(const cv::Mat& gray, Lattice& lattice, int longest) {
  refine_all(gray, lattice, true);
  std::map<LatticePlace, std::size_t> tried;  // with how many corners around
  bool again = false;                         // places that failed are tried again when nothing else is left to do
  while (!lattice.empty()) {
    std::set<LatticePlace> open;
    for (const auto& [place, saddle] : lattice) {
      for (const LatticePlace& side : kSides) {
        if (!lattice.contains(moved(place, side))) open.insert(moved(place, side));
      }
    }
    std::size_t added = 0;
    for (const LatticePlace& place : open) {
      if (!again && tried.contains(place)) continue;
      const LatticeExtent extent = extent_of(lattice);
      const int width = std::max(extent.high_x, place.first) - std::min(extent.low_x, place.first) + 1;
      const int height = std::max(extent.high_y, place.second) - std::min(extent.low_y, place.second) + 1;
      if (width > longest || height > longest) continue;
      std::size_t around = 0;
      for (int k = 0; k < 25; ++k) around += lattice.contains(moved(place, {k % 5 - 2, k / 5 - 2}));
      if (tried[place] >= around) continue;
      tried[place] = around;
      const auto start = predicted_on_lattice(lattice, place);
      if (!start) continue;
      const auto saddle = refined_on_lattice(gray, lattice, place, *start, true);
      if (!saddle) continue;
      lattice.emplace(place, *saddle);
      ++added;
    }
    if (added == 0 && again) break;
    again = added == 0;
  }
  drop_unsupported(gray, lattice);
  refine_all(gray, lattice, false);
  drop_outliers(lattice);
}

}  // namespace raybundle
