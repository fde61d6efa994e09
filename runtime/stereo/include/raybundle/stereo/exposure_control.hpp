// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/device/image_view.hpp"
#include "raybundle/device/state.hpp"
#include "raybundle/stereo/image_sensor.hpp"

namespace raybundle {

/// A rectangle of the image that should be well exposed. It counts by its weight, whatever its size.
struct ExposureArea {
  int x_px = 0;
  int y_px = 0;
  int width_px = 0;
  int height_px = 0;
  double weight = 1.0;
};

struct ExposureOptions {
  double target_grey = 90.0;   ///< wanted median of the areas
  double bright_grey = 230.0;  ///< that at most a share of the areas may exceed, below the sensor's saturated_grey
  double bright_share = 0.1;   ///< the share; it takes precedence over the target
  double hold = 0.02;          ///< relative error of the brightness below which the exposure stays as it is
};

/// What was seen and what to do about it.
struct ExposureReport {
  State state = State::kInvalid;  ///< kDegraded: a limit is reached; kInvalid: no image of the stated size
  Exposure next;                  ///< to be set
  bool too_dark = false;          ///< the scene wants more than the longest shutter and the largest gain
  bool too_bright = false;        ///< the scene wants less than the shortest shutter and the least gain
  bool settled = false;           ///< the image is as bright as wanted, or as near to it as the sensor's steps allow
  double median_grey = 0.0;       ///< of the areas
  double saturated_share = 0.0;   ///< of the areas
};

/// The exposure of a wanted product that limits and steps allow: shutter first, since gain amplifies noise, then gain,
/// which also makes up for what the shutter's steps leave out.
Exposure exposure_of(const SensorLimits& limits, double effective_s);

/// Chooses shutter and gain from the brightness of areas of the image.
///
/// Each image tells how bright the scene is: grey values over the exposure it was taken with. So the wanted exposure
/// does not depend on what is on its way to the sensor, and latency cannot make the control oscillate. The control goes
/// half of the way there, in stops, with each image. An image that is too dark or saturated gives only a bound: the
/// exposure is at once moved beyond it by a fixed factor. update() takes no memory and throws nothing.
class ExposureControl {
 public:
  /// @param areas  inside the image, with some weight; none: the whole image
  /// @throws Error(kBadInput) for limits, options, or areas that cannot be
  ExposureControl(ImageSize size, const SensorLimits& limits, const std::vector<ExposureArea>& areas = {},
                  const ExposureOptions& options = {});

  /// @param taken_with  the exposure of this image
  ExposureReport update(GreyView image, const Exposure& taken_with);

  /// Where the control begins: shortest shutter and least gain, so that nothing is saturated for long.
  Exposure next() const { return exposure_of(limits_, effective_s_); }

 private:
  ImageSize size_;
  SensorLimits limits_;
  std::vector<ExposureArea> areas_;
  ExposureOptions options_;
  double effective_s_;
};

}  // namespace raybundle
