// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "json_node.hpp"
#include "json_text.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// Beams, their grid and, where there is one, the grating: what calibration.json holds under `laser`.
OrderedJson json_from_pattern(const LaserPattern& pattern);
LaserPattern pattern_from(const JsonNode& node);

/// The grid and what fixes the origin of labels: what observations.json holds under `laser`.
OrderedJson json_from_laser(const ProblemLaser& laser);
ProblemLaser laser_from(const JsonNode& node);

/// [[u, v, cuu, cuv, cvv, row, column, brightness], ...]; row and column are null for a dot without a label.
OrderedJson json_from_dots(const std::vector<Dot>& dots, const LaserGrid& grid);
std::vector<Dot> dots_from(const JsonNode& rows, const LaserGrid& grid);

}  // namespace raybundle
