// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "raybundle/structured_light/sensor_table.hpp"

namespace raybundle {

/// Where a dot of a beam is seen.
struct CurvePoint {
  Eigen::Vector2d pixel;
  double depth_m = 0.0;
};

/// A beam's dots from the farthest to the nearest depth, at most `step_px` apart; those in the image only.
std::vector<CurvePoint> beam_curve(const Camera& camera, const Line3& line_in_camera, const SensorRange& range,
                                   double step_px);

/// Beams by the cells that their curves pass, give or take `margin_px`.
CandidateLists candidate_lists(const ImageSize& size, const std::vector<std::vector<CurvePoint>>& curves,
                               double margin_px);

}  // namespace raybundle
