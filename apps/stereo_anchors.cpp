// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_anchors.hpp"

#include "laser_images.hpp"

namespace raybundle::apps {
namespace {

SensorFlags of_camera(SensorFlags sensor, const std::string& camera) {
  sensor.camera = camera;
  return sensor;
}

}  // namespace

LaserAnchors::LaserAnchors(const std::string& calibration, const SensorFlags& sensor, const RigCamera& left,
                           const Rectification& pair)
    : pair_(pair), table_(table_from_calibration(calibration, of_camera(sensor, left.name))), sensor_(table_) {}

std::span<const AnchorDot> LaserAnchors::take(const cv::Mat& lit, const cv::Mat& dark) {
  dots_.clear();
  for (const LaserPoint& point : sensor_.process(view_of(lit), view_of(dark)).points) {
    if (const auto dot = anchor_dot(pair_, point.x_in_camera, point.covariance)) dots_.push_back(*dot);
  }
  return dots_;
}

}  // namespace raybundle::apps
