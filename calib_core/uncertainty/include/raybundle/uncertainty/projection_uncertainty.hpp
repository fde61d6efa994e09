// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// The range of points that are infinitely far.
inline constexpr double kInfinitelyFar = std::numeric_limits<double>::infinity();

/// How uncertain a camera's projections are; made once, asked for many pixels.
struct ProjectionUncertainty {
  Camera camera;
  Eigen::MatrixXd covariance;  ///< of Camera::parameters; zero for those that were held fixed
  Eigen::Matrix<double, 6, Eigen::Dynamic> implied_motion;  ///< as CornerEvidence
};

/// @param covariance  Calibration::covariance, or another one of the same parameters
/// @throws Error(kBadInput) when the calibration does not hold the camera's CornerEvidence
ProjectionUncertainty projection_uncertainty(const RigCamera& camera, const Covariance& covariance);

/// Covariance [px²] of where the camera sees a point that it now sees at a pixel.
///
/// Another sample of the same boards, with other noise, would give other parameters and, with them, another place of
/// the camera among the boards. The point stays where it is among the boards. So the rotation that the data cannot
/// tell from a shift of the principal point, say, is taken out, and at finite ranges the translation as well.
///
/// @param range_m  distance from the camera's centre, > 0, or kInfinitelyFar
/// @return         nothing where no ray lands on the pixel
std::optional<Eigen::Matrix2d> projection_covariance(const ProjectionUncertainty& uncertainty,
                                                     const Eigen::Vector2d& pixel, double range_m);

/// By what that covariance follows from the one of Camera::parameters, whatever that is: D covariance Dᵀ.
///
/// @return  D [px], 2 x parameters; nothing where no ray lands on the pixel
std::optional<Eigen::Matrix2Xd> projection_derivatives(const ProjectionUncertainty& uncertainty,
                                                       const Eigen::Vector2d& pixel, double range_m);

/// Standard deviation [px] in the direction in which it is largest.
double largest_sigma(const Eigen::Matrix2d& covariance);

/// largest_sigma of projection_covariance over a whole image.
struct UncertaintyMap {
  ImageSize size;
  double range_m = kInfinitelyFar;
  Eigen::MatrixXd
      sigma_px;  ///< one entry for each of equal cells of the image, at its middle; NaN where there is no ray

  /// Middle of a cell.
  Eigen::Vector2d pixel(Eigen::Index row, Eigen::Index column) const;
};

/// @param columns  cells along the image's width, > 0; as many rows as make them square
UncertaintyMap uncertainty_map(const ProjectionUncertainty& uncertainty, double range_m, int columns = 60);

/// The same by whichever is larger of what several covariances of one camera's parameters say.
UncertaintyMap uncertainty_map(std::span<const ProjectionUncertainty> of_camera, double range_m, int columns = 60);

}  // namespace raybundle
