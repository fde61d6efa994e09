// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/synthetic/rig.hpp"

namespace raybundle {

/// The rays of an image's pixels and of a margin around it: exact ones for the corners of pixels, bilinear between
/// them, which deviates by less than (1 px)² / (8 f) in pixels.
class CameraRays {
 public:
  /// @param margin_px  pixels beside the image that are needed too
  CameraRays(const SimulatedCamera& camera, int margin_px);

  int margin() const { return margin_; }
  int columns() const { return columns_; }  ///< of corners
  const std::vector<Eigen::Vector3d>& corners() const { return corners_; }

  /// Index of a pixel's top-left corner in corners().
  int corner(int x, int y) const { return (y + margin_) * columns_ + x + margin_; }

  /// Whether the lens sends light to the whole pixel.
  bool lit(int x, int y) const;

  /// In the camera's frame, nearly of unit length.
  ///
  /// @param u, v  place in the pixel, 0 to 1
  Eigen::Vector3d at(int x, int y, double u, double v) const;

  /// Share of the light of the axis that the lens lets through to a pixel of the image, row by row.
  const std::vector<float>& vignetting() const { return vignetting_; }

 private:
  int margin_, columns_;
  std::vector<Eigen::Vector3d> corners_;  ///< NaN where no ray lands
  std::vector<float> vignetting_;
};

}  // namespace raybundle
