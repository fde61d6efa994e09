// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/device/image_view.hpp"
#include "raybundle/scene/laser.hpp"

namespace raybundle {

/// What is known of the sensor's noise and of the spots; grey values are of 8 bits.
struct DotFinderOptions {
  double read_noise = 0.5;          ///< standard deviation of a pixel in the dark [grey]
  double grey_per_electron = 0.03;  ///< shot noise has variance grey_per_electron * grey [grey²]
  double least_signal = 6.0;        ///< of a spot over its surroundings, in sigmas of a smoothed pixel
  double largest_sigma_px = 3.5;    ///< of a spot, along its longer axis
  double most_uncertain_px = 0.2;   ///< of a centre: noise alone makes a spot of the least signal half as uncertain
};

/// Finds laser dots: spots that are brighter than what is around them on all sides. Edges of sunlight and shadows,
/// ridges, single hot pixels and reflexes too large for a dot are none.
///
/// Two passes: at half the resolution, places brighter than opposite places on a ring around them; at full resolution,
/// the centre by a weighted mean whose weights fall smoothly to zero and which lie on the centre itself, so that
/// neither the window's rim nor its place in the pixel grid pulls at it. Its covariance is that of shot noise, read
/// noise and the unrest of the surroundings. An image full of spots costs no more than so many peaks: the strongest.
class DotFinder {
 public:
  /// All memory is taken here.
  ///
  /// @param most_dots  the strongest ones are kept
  DotFinder(ImageSize size, int most_dots, const DotFinderOptions& options = {});

  /// @param on   image with the laser on; of the size said at the start
  /// @param off  the same scene with the laser off, or a view without pixels
  /// @return     dots in the order of the image's rows; brightness is the sum of grey values above the surroundings,
  ///             weighted as for the centre. Valid until the next call
  std::span<const Dot> find(const GreyView& on, const GreyView& off = {});

 private:
  struct Peak {
    int u = 0, v = 0;  ///< at half the resolution
    std::int16_t signal = 0;
  };

  void halve(const GreyView& on, const GreyView& off);
  void smooth();
  void outshine();
  void find_peaks(const GreyView& on, bool difference);
  void keep_strongest_peaks();

  ImageSize size_;
  DotFinderOptions options_;
  int width_, height_;  ///< at half the resolution
  std::vector<std::int16_t> half_, rows_, smooth_, signal_;
  std::vector<Peak> peaks_;
  std::size_t most_peaks_;
  std::vector<Dot> dots_;
  std::size_t most_dots_;
};

}  // namespace raybundle
