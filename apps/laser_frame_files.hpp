// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "raybundle/structured_light/structured_light.hpp"

namespace raybundle::apps {

/// What one image says, as texts and bytes of files. The formats: docs/formats/laser_points.md.
struct LaserFrameFiles {
  std::string json;
  std::string ply;
  std::string glb;
  std::string html;  ///< a page of its own: the image with the labelled dots, the points in space
};

/// @param image  the path, for the record
/// @param grey   8 bits, shown on the page
LaserFrameFiles laser_frame_files(const LaserFrame& frame, const SensorTable& table, const std::string& image,
                                  const cv::Mat& grey);

}  // namespace raybundle::apps
