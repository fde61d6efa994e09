// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ellipse.hpp"

namespace raybundle {

/// Blobs among which a pattern is looked for, and circles that a pattern may have: the way through them is quadratic.
inline constexpr std::size_t kMostEllipses = 3000;

/// A grid of circles as whole numbers: where each circle lies on the lattice that its neighbours span.
struct CirclePattern {
  std::vector<std::pair<int, int>> cells;   ///< by point id
  std::vector<Eigen::Vector2d> x_in_board;  ///< [m] by point id
  double spacing_m = 0.0;                   ///< between nearest circles
};

struct CircleMatch {
  std::map<int, std::size_t> ellipse_of;  ///< point id -> index of the ellipse
  std::string hint;                       ///< when a grid was seen that is not this one
};

/// Finds a pattern among ellipses: grows lattices from neighbour to neighbour, which follows any distortion, and lays
/// the pattern over the largest. Up to a tenth of the circles may be missing, as long as no other place fits as well. Of
/// more than kMostEllipses the largest count.
CircleMatch match_circles(const std::vector<Ellipse>& ellipses, const CirclePattern& pattern);

}  // namespace raybundle
