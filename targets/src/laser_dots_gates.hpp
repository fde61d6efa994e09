// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "laser_dots_fit.hpp"

namespace raybundle {

enum class SpotFate { kGood, kSaturated, kClipped, kDoubled, kFaint, kStreak, kOnEdge };

/// A peak on its way to a dot.
struct SpotCandidate {
  SpotFit fit;
  Eigen::Vector2d peak = Eigen::Vector2d::Zero();
  SpotFate fate = SpotFate::kGood;
};

/// Shapes of the good spots of an image: their median and how they scatter.
SpotShape usual_shape(const std::vector<SpotCandidate>& candidates, const SpotShape& otherwise);

/// Gaussian sigma of a round spot of the same area [px].
double mean_sigma(const Eigen::Matrix2d& precision);

/// Whether full scale was reached within two sigmas of a place.
bool is_saturated(const DotImages& images, const Eigen::Vector2d& pixel, double sigma_px);

/// Whether the image's border is within two and a half sigmas of a place.
bool is_clipped(const DotImages& images, const Eigen::Vector2d& pixel, double sigma_px);

/// What a fit is, apart from its neighbours.
SpotFate fate_of(const SpotFit& fit, const SpotShape& usual, bool pair, const Eigen::Vector2d& peak,
                 const DotOptions& options);

/// Marks spots whose light overlaps too much to tell it apart.
void mark_doubles(std::vector<SpotCandidate>& candidates, double sigma_px);

}  // namespace raybundle
