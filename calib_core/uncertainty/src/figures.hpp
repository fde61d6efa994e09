// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "raybundle/uncertainty/requirements.hpp"

namespace raybundle {

/// Whom a requirement is about: a camera, two of them together, or the laser with the first camera.
struct Subject {
  int first = 0;
  int second = -1;  ///< nothing: -1
  bool laser = false;
  std::string name;
};

/// Empty when the calibration does not have the camera that is named, or nothing in it tells a depth.
std::vector<Subject> subjects_of(const Requirement& requirement, const Calibration& calibration);

/// The uncertainty that a requirement limits.
struct Figure {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< [px] or [m]; NaN where it cannot be told anywhere
  double rms = std::numeric_limits<double>::quiet_NaN();    ///< over all places, in the same unit
  Eigen::Vector2d worst = Eigen::Vector2d::Zero();          ///< pixel of the first camera where it is reached
  double unseen_share = 0.0;                                ///< of the places in question: no corner was seen there
  double reach_rad = 0.0;                                   ///< largest angle off the axis among the places
};

/// Sigma of a beam's depth as the calibration states it, between two of kStatedDepths_m by a power of the depth; NaN
/// outside of them.
double stated_beam_sigma(const LaserBeam& beam, double depth_m);

/// Of sigmas of beams' depths, those that are NaN left out.
Figure figure_of_beams(const std::vector<double>& sigmas);

/// Projections: the largest sigma of all places. Depths: the one that 95 % of the places or beams stay below.
///
/// @param covariance  Calibration::covariance, or another one of the same parameters
/// @param columns     places across the image
Figure figure_of(const Requirement& requirement, const Subject& subject, const Calibration& calibration,
                 const Covariance& covariance, int columns);

}  // namespace raybundle
