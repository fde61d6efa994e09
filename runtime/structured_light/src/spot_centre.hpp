// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "raybundle/device/image_view.hpp"

namespace raybundle {

/// Noise of a pixel: variance read² + grey_per_electron * grey.
struct SpotNoise {
  double read = 0.0;
  double grey_per_electron = 0.0;
};

struct MeasuredSpot {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance_px2;
  double major_sigma_px = 0.0;  ///< of the spot's light, along its longer axis
  double brightness = 0.0;      ///< sum of grey values above the surroundings, weighted as for the centre
};

/// The centre of a spot near a place; nothing where there is none, or one that is a single hot pixel, a plateau, a
/// ridge or an edge.
///
/// @param off  image without the laser, or a view without pixels
std::optional<MeasuredSpot> spot_centre(const GreyView& on, const GreyView& off, const Eigen::Vector2d& start,
                                        const SpotNoise& noise);

}  // namespace raybundle
