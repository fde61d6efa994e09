// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace raybundle {

/// A point where four alternately dark and bright sectors meet: the inner corner of a chessboard.
struct Saddle {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< [px], (0, 0) is the centre of the top-left pixel
  double sigma_px = 1.0;                            ///< standard deviation of each coordinate
  /// Unit vectors along the two edges through the corner. Looking at the image (x right, y down), turning clockwise
  /// from edge_a to edge_b by less than 180° crosses a bright sector.
  Eigen::Vector2d edge_a = Eigen::Vector2d::UnitX();
  Eigen::Vector2d edge_b = Eigen::Vector2d::UnitY();
  double contrast = 0.0;  ///< bright minus dark level, in grey values of the image
  double misfit = 0.0;    ///< rms of the model's residuals over the contrast: 0 is a perfect corner
};

/// Refines a saddle near `start`, or finds that there is none.
///
/// @param gray       8-bit single channel
/// @param radius_px  the window's radius; at most the distance to the nearest other edge or corner, 3 px at least
/// @return           nothing when contrast, shape or residuals say that this is not a saddle, or when it lies further
///                   than the radius from the start or too near to the image's border
std::optional<Saddle> refine_saddle(const cv::Mat& gray, const Eigen::Vector2d& start, double radius_px);

/// The same for a window that follows the lattice: a parallelogram whose half-sides are the vectors towards the
/// neighbouring corners, scaled by the caller (.7 keeps clear of them).
std::optional<Saddle> refine_saddle(const cv::Mat& gray, const Eigen::Vector2d& start, const Eigen::Vector2d& half_x,
                                    const Eigen::Vector2d& half_y);

}  // namespace raybundle
