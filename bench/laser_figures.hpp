// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/scene/calibration.hpp"
#include "raybundle/uncertainty/held_out_dots.hpp"

namespace raybundle::bench {

/// The beam of that row and column, or null.
inline const LaserBeam* beam_of(const LaserPattern& pattern, int row, int column) {
  const auto found =
      std::ranges::find_if(pattern.beams, [&](const LaserBeam& b) { return b.row == row && b.column == column; });
  return found == pattern.beams.end() ? nullptr : &*found;
}

/// Error of the depth that an exact dot at 1 m is given: median over the beams of its size [mm]; infinite without
/// beams.
inline double depth_bias_mm(const Calibration& truth, const Calibration& found) {
  std::vector<double> errors;
  for (const LaserBeam& beam : truth.laser->beams) {
    const LaserBeam* ours = beam_of(*found.laser, beam.row, beam.column);
    const RigCamera& camera = truth.cameras[0];
    const Line3 line = camera.camera_from_rig * beam.line;
    const Eigen::Vector3d place = line.at((1.0 - line.point.z()) / line.direction.z());
    const auto pixel = pixel_from_ray(camera.camera, place);
    if (ours == nullptr || !pixel) continue;
    const auto at = point_on_beam(found.cameras[0], ours->line, *pixel, (place - ours->line.point).norm());
    if (at) errors.push_back(1e3 * std::abs((found.cameras[0].camera_from_rig * *at).z() - 1.0));
  }
  return errors.empty() ? INFINITY : median(errors);
}

}  // namespace raybundle::bench
