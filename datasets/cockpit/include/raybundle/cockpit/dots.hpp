// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "raybundle/cockpit/cabin_scene.hpp"
#include "raybundle/cockpit/sensor.hpp"
#include "raybundle/scene/laser.hpp"

namespace raybundle {

/// The spot of a beam that the camera sees.
struct CabinDot {
  Dot dot;  ///< as measured, labelled; `beam` is the index in LaserGrid, or kUnlabelled for a spurious dot
  Eigen::Vector2d true_pixel = Eigen::Vector2d::Zero();
  Eigen::Vector3d x_in_vehicle = Eigen::Vector3d::Zero();  ///< [m] where beam and surface really meet
  CabinPart part = CabinPart::kCar;
};

struct CabinDotOptions {
  std::uint64_t seed = 1;    ///< of the noise
  std::uint64_t stream = 0;  ///< noise of different streams of one seed is independent: a frame
  double spurious = 0.0;     ///< false dots anywhere in the image, over the true ones
};

/// What a detector makes of an image without its being rendered: the dots of all beams whose spot stands out from the
/// noise. A dot's noise follows from its electrons, the light beneath it, the width of its image and speckle; a dot
/// that an edge cuts is biased towards what is left of it.
///
/// @param sensor  with an emitter
std::vector<CabinDot> dots_of(const CabinScene& scene, const CabinSensor& sensor, const CabinDotOptions& options = {});

/// A place that was measured, with its uncertainty.
struct CabinPoint {
  int ray = 0;  ///< beam in LaserGrid, or pixel of the first camera row by row: the same in every frame
  Eigen::Vector3d x_in_vehicle = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  CabinPart part = CabinPart::kCar;  ///< truth
};

/// Dots in space, as a calibrated runtime that labels them rightly has them: the beam's point nearest to the camera's
/// ray. Dots without label are left out.
std::vector<CabinPoint> points_of(const std::vector<CabinDot>& dots, const CabinSensor& sensor);

}  // namespace raybundle
