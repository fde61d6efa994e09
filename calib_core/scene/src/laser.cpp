// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/laser.hpp"

#include <cassert>
#include <cmath>

namespace raybundle {

std::optional<Line3> beam_of_order(const Grating& grating, double m, double n) {
  const Eigen::Vector2d step(m * grating.column_pitch + n * grating.row_pitch * std::sin(grating.skew_rad),
                             n * grating.row_pitch * std::cos(grating.skew_rad));
  const Eigen::Vector2d cosines = grating.wavelength_scale * step;
  const double s2 = cosines.squaredNorm();
  const Eigen::Vector2d spread = cosines * (1.0 + s2 * (grating.k1 + s2 * grating.k2));
  if (s2 >= 1.0 || spread.squaredNorm() >= 1.0) return std::nullopt;
  const Eigen::Vector3d direction(spread.x(), spread.y(), std::sqrt(1.0 - spread.squaredNorm()));
  const Eigen::Vector3d point(0.0, 0.0, grating.shift_m * s2);
  return grating.rig_from_projector * Line3{point, direction};
}

std::optional<Line3> line_of_model(const LaserPattern& pattern, int row, int column) {
  if (!pattern.grating) return std::nullopt;
  return beam_of_order(*pattern.grating, column - pattern.zero_order_column, row - pattern.zero_order_row);
}

LaserPattern at_wavelength(const LaserPattern& pattern, double scale) {
  assert(pattern.grating);
  LaserPattern moved = pattern;
  moved.grating->wavelength_scale = scale;
  for (LaserBeam& beam : moved.beams) {
    const std::optional<Line3> before = line_of_model(pattern, beam.row, beam.column),
                               after = line_of_model(moved, beam.row, beam.column);
    if (before && after) beam.line = perturbed(*after, motion_between(*before, beam.line));
  }
  return moved;
}

}  // namespace raybundle
