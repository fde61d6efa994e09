// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "raybundle/geometry/line.hpp"

namespace raybundle {

/// Where the beams seem to come from, and how far they pass it by.
struct BeamSource {
  Eigen::Vector3d apex = Eigen::Vector3d::Zero();
  double spread_m = 0.0;
};

/// Of the places where two lines come near each other the one that most lines pass closely, then reweighted least
/// squares: chance lines go elsewhere and do not count.
///
/// @return  nothing with fewer than 4 lines, or when all are parallel
std::optional<BeamSource> source_of(const std::vector<Line3>& lines);

}  // namespace raybundle
