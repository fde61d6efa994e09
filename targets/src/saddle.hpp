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
  double blur_px = 1.0;   ///< standard deviation of the edges' blur
  double misfit = 0.0;    ///< the model's residuals, by degree of freedom, over the contrast: 0 is a perfect corner
};

/// The neighbourhood of a corner on a lattice: a parallelogram with a tapered edge, and how its edges bend.
struct SaddleWindow {
  Eigen::Vector2d half_x = Eigen::Vector2d::UnitX();  ///< [px] half-side along one edge; .7 of the step keeps clear
  Eigen::Vector2d half_y = Eigen::Vector2d::UnitY();  ///< [px] half-side along the other edge
  double bend_x = 0.0;  ///< [1/px] curvature of the edge along half_x, positive towards half_x turned clockwise
  double bend_y = 0.0;  ///< [1/px] the same for the edge along half_y
  const Saddle* known = nullptr;  ///< an earlier fit of this corner: where to start
  bool doubtful = false;          ///< perhaps there is no corner at all: look before fitting
  bool rough = false;             ///< a window of 6 px that need not lie on the corner: to look, another fit follows
};

/// Refines a saddle near `start`, or finds that there is none.
///
/// @param gray       8-bit single channel
/// @param radius_px  the window's radius; at most the distance to the nearest other edge or corner, 3 px at least
/// @return           nothing when contrast, shape or residuals say that this is not a saddle, or when it lies further
///                   than about half the radius from the start or too near to the image's border
std::optional<Saddle> refine_saddle(const cv::Mat& gray, const Eigen::Vector2d& start, double radius_px);

/// The same for a window that follows the lattice; the expected edges are the window's sides, in either polarity.
std::optional<Saddle> refine_saddle(const cv::Mat& gray, const Eigen::Vector2d& start, const SaddleWindow& window);

/// Directions of the edges through a point, read off a circle around it: four changes between dark and bright.
struct SaddleRing {
  double angle_a = 0.0;   ///< [rad] of Saddle::edge_a, clockwise from x
  double angle_b = 0.0;   ///< [rad] of Saddle::edge_b, angle_a < angle_b < angle_a + pi
  double contrast = 0.0;  ///< grey values between the bright and the dark arcs
};
std::optional<SaddleRing> saddle_ring(const cv::Mat& gray, const Eigen::Vector2d& centre, double radius_px);

}  // namespace raybundle
