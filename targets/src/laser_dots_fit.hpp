// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "laser_dots_images.hpp"

namespace raybundle {

/// A Gaussian spot, amplitude exp(-½ dᵀ precision d) times the relative reflectance.
struct Spot {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double amplitude = 0;                                     ///< [grey]
  Eigen::Matrix2d precision = Eigen::Matrix2d::Identity();  ///< [1/px²] inverse of the spot's second moments

  double value(const Eigen::Vector2d& at) const;  ///< [grey] on a surface of relative reflectance 1
};

/// The samples around a spot, one entry per pixel.
struct SpotWindow {
  Eigen::Vector2d origin;  ///< [px] the offsets' zero
  double black = 0;
  std::vector<double> x, y, signal, variance, reflectance, background;
  std::vector<char> near;           ///< within three sigmas
  std::vector<char> rim;            ///< within three sigmas, beyond two
  bool pair = false;                ///< the background is known from the laser-off image, and the reflectance
  double reflectance_variance = 0;  ///< of the relative reflectances
  double contrast = 0;              ///< spread of the relative reflectance within three sigmas, 0 to 1

  std::size_t size() const { return x.size(); }
};

/// What is expected of a spot's shape before it is fitted.
struct SpotShape {
  Eigen::Matrix2d precision = Eigen::Matrix2d::Identity();
  double relative_sigma = 0.5;  ///< of the precision's entries, relative to the mean of its diagonal
};

struct SpotFit {
  Spot spot;
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();  ///< inverse Fisher information
  double amplitude_sigma = 1;                                    ///< [grey]
  double goodness = 1;  ///< weighted squares of the residuals over the degrees of freedom, near the spot
  double misfit = 0;    ///< rms of what noise does not explain, over the amplitude
  bool converged = false;
};

/// The window around a place; pixels of other spots have these subtracted.
SpotWindow spot_window(const DotImages& images, const Eigen::Vector2d& pixel, double sigma_px,
                       const std::vector<const Spot*>& others);

/// Whether a spot of this amplitude lies on an even surface. Then pixels of other surfaces around it are taken out of
/// the window, and the background is not taken from the laser-off image, whose noise is as much as the spot's own.
bool take_even_surface(SpotWindow& window, double amplitude, const GreyNoise& noise);

SpotFit fit_spot(const SpotWindow& window, const Spot& start, const SpotShape& shape, const GreyNoise& noise);

}  // namespace raybundle
