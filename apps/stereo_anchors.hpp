// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/stereo/dot_fusion.hpp"
#include "raybundle/structured_light/structured_light.hpp"
#include "sensor_input.hpp"

namespace raybundle::apps {

/// Dots of the rig's own laser in images of the left camera, as anchors of a stereo pair's depth.
class LaserAnchors {
 public:
  /// @param calibration  path of calibration.json
  /// @param sensor       depths and tolerance of the dots; the camera is the left one, whatever it says
  /// @throws Error(kBadInput) when the calibration holds no laser beams
  LaserAnchors(const std::string& calibration, const SensorFlags& sensor, const RigCamera& left,
               const Rectification& pair);
  LaserAnchors(const LaserAnchors&) = delete;
  LaserAnchors& operator=(const LaserAnchors&) = delete;

  /// @param lit   with the laser on, of 8 bits
  /// @param dark  the same moment with it off; empty: none
  /// @return      valid until the next call
  std::span<const AnchorDot> take(const cv::Mat& lit, const cv::Mat& dark);

 private:
  Rectification pair_;
  SensorTable table_;
  StructuredLight sensor_;  // which looks into the table
  std::vector<AnchorDot> dots_;
};

}  // namespace raybundle::apps
