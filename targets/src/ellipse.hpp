// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace raybundle {

/// The image of a printed circle. Its outline is |shape^(-1/2) (x - centre)| = 1.
struct Ellipse {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();     ///< [px]
  Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();  ///< [px²] eigenvalues are the squared semi-axes
  bool dark = true;                                     ///< darker than its ground
  double sigma_px = 1.0;                                ///< of each of the centre's coordinates
};

/// Dark and bright blobs whose outline is an ellipse, good to half a pixel or so.
///
/// @param block_px  window of the adaptive threshold, odd, larger than a blob
std::vector<Ellipse> find_ellipses(const cv::Mat& gray, int block_px);

/// The blob at a place, cut out by the mean of the dark and the bright level within `reach_px`; nothing when no outline
/// around the place is an ellipse.
std::optional<Ellipse> find_ellipse_at(const cv::Mat& gray, const Eigen::Vector2d& place, double reach_px);

/// Sub-pixel ellipse from the gradients along its outline; nothing when they do not make one.
/// Source: Ouellet and Hébert, Precise ellipse estimation without contour point extraction, MVA 2009, eq. 8.
std::optional<Ellipse> refine_ellipse(const cv::Mat& gray, const Ellipse& rough);

}  // namespace raybundle
