// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/scene/calibration.hpp"
#include "raybundle/stereo/rectified_camera.hpp"

namespace raybundle {

/// What the rectified images should be; what is left out follows from the cameras.
struct RectifyOptions {
  std::optional<RectifiedProjection> projection = {};  ///< else the advised one
  int width_px = 0;           ///< 0: the centre is sampled as densely as in the denser camera image
  int height_px = 0;          ///< 0: follows from the width and the field
  double field_x_rad = 0.0;   ///< whole field of view along the baseline, about the z axis; 0: all that a camera sees
  double field_y_rad = 0.0;   ///< the same across it
  int samples_per_side = 97;  ///< places along each side of an image that stand for its field; 2 at least
};

/// A stereo pair turned so that a point has the same row in both images.
struct Rectification {
  RectifiedCamera camera;                   ///< of both images
  double baseline_m = 0.0;                  ///< > 0
  Eigen::Quaterniond rectified_from_left;   ///< rotation from the left camera's frame
  Eigen::Quaterniond rectified_from_right;  ///< rotation from the right camera's frame
  Rigid3 rig_from_rectified;                ///< from the left rectified camera, in whose frame points are given

  double field_x_rad = 0.0;      ///< along the baseline, between the outermost pixels of the middle row
  double field_y_rad = 0.0;      ///< across it
  double kept_left = 0.0;        ///< share of the left image whose rays the rectified image shows
  double kept_right = 0.0;       ///< the same of the right image
  double rim_over_centre = 1.0;  ///< how much denser the rectified image samples its left or right rim than its centre
};

/// The field of view in which a pinhole image samples its rim less than twice as densely as its centre: up to it the
/// advised projection is a pinhole.
inline constexpr double kPinholeAdvisedField_rad = M_PI_2;

/// Rectifies two calibrated cameras of any models.
///
/// The whole field that either camera sees is kept unless the options limit it; what is kept is stated in the result.
///
/// @throws Error(kBadInput) when the cameras are at one place, look along the baseline, or `left` is not on the left;
///         when a pinhole image cannot hold the field; when a size is negative
Rectification rectify(const RigCamera& left, const RigCamera& right, const RectifyOptions& options = {});

}  // namespace raybundle
