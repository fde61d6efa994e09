// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "raybundle/device/image_view.hpp"

namespace raybundle {

/// How an image is taken.
struct Exposure {
  double shutter_s = 0.0;
  double gain = 1.0;  ///< factor, 1 is none

  /// What brightness is proportional to [s].
  double effective_s() const { return shutter_s * gain; }
};

/// What a sensor can do. Grey values grow linearly from black_grey with the effective exposure until saturated_grey.
struct SensorLimits {
  double least_shutter_s = 0.0;
  double most_shutter_s = 0.0;  ///< the frame's time, or less where motion must not blur
  double shutter_step_s = 0.0;  ///< the time of a row, commonly; 0: any shutter
  double least_gain = 1.0;
  double most_gain = 1.0;
  double gain_step = 0.0;         ///< 0: any gain
  double black_grey = 0.0;        ///< grey value without light
  double saturated_grey = 250.0;  ///< from here on a grey value says only that the light is at least so bright
};

/// A source of images with shutter and gain: a camera, or a simulated one.
class ImageSensor {
 public:
  virtual ~ImageSensor() = default;

  virtual SensorLimits limits() const = 0;

  /// Asks for an exposure. Sensors apply it some frames later.
  virtual void set(const Exposure& exposure) = 0;

  /// Waits for the next image.
  ///
  /// @param image  becomes the image
  /// @return       the exposure that this image was taken with, which a sensor with latency has to keep account of;
  ///               nothing when there is no image
  virtual std::optional<Exposure> capture(ImageView<std::uint8_t> image) = 0;
};

}  // namespace raybundle
