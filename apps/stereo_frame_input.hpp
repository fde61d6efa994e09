// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "raybundle/stereo/stereo.hpp"

namespace raybundle::apps {

/// One pair as `reconstruct stereo` wrote it, read back.
class StereoFrameInput {
 public:
  /// @param path      of NAME.json; NAME.ply lies beside it
  /// @param pictures  whether the images are read, too: NAME_left.png, NAME_right.png and NAME_disparity.png
  /// @throws Error(kIo) when a file cannot be read; Error(kBadInput) naming what is damaged
  StereoFrameInput(const std::string& path, bool pictures);

  std::string name;             ///< of the frame: NAME
  Rectification rectification;  ///< camera, baseline and rig_from_rectified; the rest is not filled
  double nearest_m = 0.0;       ///< nothing nearer was searched

  /// Views into this; the images are empty unless read.
  StereoFrame frame() const;

 private:
  void read_points(const std::string& path);
  cv::Mat picture(const std::string& path, int depth) const;

  State state_ = State::kInvalid;
  std::vector<StereoPoint> points_;
  int matched_ = 0;
  double disparity_step_px_ = 1.0 / 256;
  cv::Mat left_, right_, disparity_px_;
};

}  // namespace raybundle::apps
