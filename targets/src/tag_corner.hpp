// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace raybundle {

/// The outer corner of a dark tag on a bright ground.
struct TagCorner {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma_px = 1.0;  ///< of each coordinate
};

/// Refines a tag's corner as the crossing of its two sides, each a line through the steepest places across it.
///
/// @param inward_x  [px] from the corner along one side of the tag, as long as the side; inward_y the other one
/// @param reach_px  how far from `start` the corner may be
/// @return          nothing when a side is not there from dark (inside) to bright
std::optional<TagCorner> refine_tag_corner(const cv::Mat& gray, const Eigen::Vector2d& start,
                                           const Eigen::Vector2d& inward_x, const Eigen::Vector2d& inward_y,
                                           double reach_px);

}  // namespace raybundle
