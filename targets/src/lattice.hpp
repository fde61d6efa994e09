// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "saddle.hpp"
#include "saddle_candidates.hpp"

namespace raybundle {

/// Column and row of a corner on a lattice whose origin is arbitrary.
using LatticePlace = std::pair<int, int>;

/// Corners on a square lattice: x to the right of y as on the printed side, never mirrored, turned by any quarter.
/// Where column + row is even, the square towards larger column and row is bright; where it is odd, dark.
using Lattice = std::map<LatticePlace, Saddle>;

/// First and last column and row that hold a corner.
struct LatticeExtent {
  int low_x = 0, high_x = -1, low_y = 0, high_y = -1;
  int width() const { return high_x - low_x + 1; }
  int height() const { return high_y - low_y + 1; }
};
LatticeExtent extent_of(const Lattice& lattice);

/// The lattices that candidates form when neighbours see each other along an edge; largest first.
///
/// @param blurred  the image in which the candidates were found
std::vector<Lattice> linked_lattices(const std::vector<SaddleCandidate>& candidates, const cv::Mat& blurred);

/// True when an edge runs all the way from one corner to the next, bright on the expected side.
///
/// @param least_contrast  grey values between the two sides, near the line or at a fifth of the length beside it
bool edge_between(const cv::Mat& image, const Eigen::Vector2f& from, const Eigen::Vector2f& to, bool bright_clockwise,
                  float least_contrast);

/// The window of a corner from its neighbours' places, whether or not the corner itself is on the lattice.
///
/// @param at  pixel of the corner
/// @return    nothing when an axis has no neighbour
std::optional<SaddleWindow> window_on_lattice(const Lattice& lattice, LatticePlace place, const Eigen::Vector2d& at);

/// Where a corner should be, extrapolated from the corners around it; nothing when they are too few.
std::optional<Eigen::Vector2d> predicted_on_lattice(const Lattice& lattice, LatticePlace place);

/// Refines a corner where the lattice expects it; nothing when there is no saddle of the lattice's orientation,
/// polarity and contrast within a fraction of a square.
///
/// @param rough  as in SaddleWindow: to look, not to measure
/// @param known  an earlier fit of this corner, when there is one
std::optional<Saddle> refined_on_lattice(const cv::Mat& gray, const Lattice& lattice, LatticePlace place,
                                         const Eigen::Vector2d& start, bool rough = false,
                                         const Saddle* known = nullptr);

/// Refines all corners, drops those that are not corners, then adds missing ones while neighbours predict them.
///
/// @param longest  corners along a side beyond which the lattice must not grow
void grow_lattice(const cv::Mat& gray, Lattice& lattice, int longest);

}  // namespace raybundle
