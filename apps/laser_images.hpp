// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "image_files.hpp"
#include "raybundle/device/image_view.hpp"
#include "raybundle/structured_light/sensor_table.hpp"

namespace raybundle::apps {

/// The files of one moment.
struct LaserShot {
  std::string on;
  std::string off;  ///< empty: none
};

/// Images with the laser on, each with that of the same moment with the laser off: the one of the same digits, as
/// frames of a data set are matched; in order where the names tell nothing.
///
/// @throws Error(kBadInput) naming an image that lacks its counterpart
std::vector<LaserShot> laser_shots(const std::vector<std::string>& on, const std::vector<std::string>& off);

/// The grey images of a shot, of 8 bits.
struct ShotImages {
  cv::Mat on;
  cv::Mat off;  ///< empty: none
};

/// Calls use(images, name) for what the files of a shot show: once for images, for every frame of videos, whose names
/// count them from 0. `use` says whether to go on.
///
/// @param bits  by which images of more bits are scaled; of all shots of a run
/// @throws Error(kIo) when a file cannot be read, Error(kBadInput) for an image of another size than the table's, or a
///         video with the laser off that is shorter than the one with it on
void for_each_moment(const LaserShot& shot, const SensorTable& table, EightBits& bits,
                     const std::function<bool(const ShotImages& images, const std::string& name)>& use);

/// As the runtime takes it; an empty image is one without pixels.
GreyView view_of(const cv::Mat& image);

}  // namespace raybundle::apps
