// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "raybundle/scene/laser.hpp"

namespace raybundle {

/// What counts as a laser's spot. The defaults need no change for a raw image of a dot pattern.
struct DotOptions {
  double least_significance = 4.7;  ///< a spot's brightness over its own sigma; those below are counted as faint
  double spot_sigma_px = 0.0;       ///< usual width of the spots, Gaussian sigma with pixel and lens; 0: estimated
  double most_elongation = 2.5;     ///< length over width, above which a spot is a streak
  double full_scale_grey = 0.0;     ///< grey value at which the sensor saturates; 0: that of 8, 10, 12, 14 or 16 bits
  double black_grey = 0.0;          ///< grey value without any light; reflectances are in proportion to what is above
  std::vector<Eigen::Vector2d> region = {};  ///< [px] convex polygon in which dots are looked for; empty: everywhere
};

/// The dots of one image, and how many spots were seen but cannot be trusted.
struct FoundDots {
  std::vector<Dot> dots;          ///< top to bottom, then left to right; unlabelled
  int saturated = 0;              ///< the sensor's full scale was reached in the spot
  int clipped = 0;                ///< the image's border cuts the spot
  int doubled = 0;                ///< two spots overlap
  int faint = 0;                  ///< seen by the filter, not confirmed by the fit
  int streaks = 0;                ///< too long, too wide or too narrow for a spot
  int on_edge = 0;                ///< print, not light, or a spot across a printed edge that cannot be told from it
  double spot_sigma_px = 0.0;     ///< median width; 0: there are no spots
  double background_noise = 0.0;  ///< [grey] standard deviation at the image's median grey value
};

/// Laser spots on a board, by maximum likelihood: each spot is an elongated Gaussian times the board's reflectance, on
/// a local background, under read and shot noise that is estimated from the images. Covariances are the inverse Fisher
/// information, times the goodness of fit where that is worse than the noise explains, plus a share of what the
/// reflectance's change across the spot moves it. Deterministic; safe to call from several threads.
///
/// @param on       8-bit or 16-bit single channel (10, 12 and 14 bits in 16 too), linear in the light, not undistorted
/// @param off      the same view with the laser off, or null. It is the background, and where there is ambient light it
///                 is the reflectance under the spots too. Without it spots on printed edges are given up.
/// @throws Error(kBadInput) when the images are of another kind, or differ in size or kind
FoundDots find_dots(const cv::Mat& on, const cv::Mat* off = nullptr, const DotOptions& options = {});

}  // namespace raybundle
