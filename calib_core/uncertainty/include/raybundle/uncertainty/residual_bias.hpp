// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// The residuals of a part of the image, or of a band of angles off the axis.
struct ResidualGroup {
  int corners = 0;
  int views = 0;                                      ///< that the corners are from
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();  ///< u and v of a part; radial and tangential of a band
  double mean_sigma_px = 0.0;                         ///< of the mean, larger direction, by how the views scatter
  double rms_px = 0.0;                                ///< root of the mean squared distance

  /// Length of the mean over its sigma; 0 for fewer than kFewestViews.
  double sigmas() const;

  /// The same of its first component alone: of a band, how far chance is from explaining what points outwards.
  double first_sigmas() const;
};

/// Views that a group needs before its mean says anything about bias: of fewer, their scatter is not known well enough.
inline constexpr int kFewestViews = 10;

/// Residuals of one camera, with what they have in common told apart from what scatters: noise averages out from view
/// to view, a wrong lens does not.
struct ResidualBias {
  ImageSize size;
  int rows = 0;
  int columns = 0;
  std::vector<ResidualGroup> parts;  ///< of the image, equal cells, row by row
  double band_rad = 0.0;             ///< width of each band of angles
  std::vector<ResidualGroup> bands;  ///< from the axis outwards
  double bias_px =
      0.0;  ///< root mean square, over the corners, of their part's mean; what chance adds to it is taken off
  double noise_px = 0.0;  ///< the rest, so that the squares of both add up to that of rms_px
  double rms_px = 0.0;
  double strongest_sigmas = 0.0;  ///< of the part whose mean chance explains least
  int strongest = -1;             ///< its index; -1 without any part of enough views

  /// Whether bias is there beyond doubt: a part's mean is beyond what chance does in as many parts.
  bool significant() const;

  /// Index of the band whose residuals point outwards or inwards most, in sigmas; -1 without any band of enough views.
  int strongest_band() const;
};

/// @param camera  index into problem.cameras
/// @param lens    as calibrated, for the angles
/// @param result  of a solve for the poses of the boards, or for everything
ResidualBias residual_bias(const CalibrationProblem& problem, const CalibrationResult& result, int camera,
                           const Camera& lens);

}  // namespace raybundle
