// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "raybundle/stereo/image_sensor.hpp"

namespace raybundle::testing {

/// Looks at a picture of light that the test may change: linear, with a pedestal, noise of the photons and of reading,
/// whole grey values that saturate, and settings that come into effect some frames late.
class SimulatedSensor : public ImageSensor {
 public:
  /// @param latency  frames that are still taken with the exposures that were set before
  SimulatedSensor(const SensorLimits& limits, int latency, unsigned seed)
      : limits_(limits), coming_(static_cast<std::size_t>(latency) + 1, exposure_at_start(limits)), random_(seed) {}

  std::vector<double> light;  ///< [grey/s] of each pixel

  SensorLimits limits() const override { return limits_; }

  void set(const Exposure& exposure) override { coming_.back() = exposure; }

  std::optional<Exposure> capture(ImageView<std::uint8_t> image) override {
    const Exposure exposure = coming_.front();
    std::rotate(coming_.begin(), coming_.begin() + 1, coming_.end());
    if (coming_.size() > 1) coming_.back() = coming_[coming_.size() - 2];
    std::normal_distribution<double> normal;
    for (int v = 0; v < image.height; ++v) {
      for (int u = 0; u < image.width; ++u) {
        const double grey = light[static_cast<std::size_t>(v) * image.width + u] * exposure.effective_s();
        // 40 electrons for each grey value at gain 1, and a reading noise of 0.3 grey
        const double sigma = std::sqrt(exposure.gain * grey / 40.0 + 0.09 * exposure.gain * exposure.gain);
        const double read = limits_.black_grey + grey + sigma * normal(random_);
        image.at(u, v) = static_cast<std::uint8_t>(std::clamp(std::lround(read), 0L, 255L));
      }
    }
    return exposure;
  }

 private:
  static Exposure exposure_at_start(const SensorLimits& limits) { return {limits.least_shutter_s, limits.least_gain}; }

  SensorLimits limits_;
  std::vector<Exposure> coming_;  // in the order of the frames
  std::mt19937 random_;
};

}  // namespace raybundle::testing
