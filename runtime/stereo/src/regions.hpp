// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/stereo/matcher.hpp"

namespace raybundle {

/// Takes out regions of smooth disparity that have too few pixels to be a surface.
class SmallRegions {
 public:
  explicit SmallRegions(ImageSize size);

  /// Neighbours in a row or column are of one region when their disparities differ by at most 0.7 px.
  ///
  /// @param disparity_px, sigma_px  become 0 in small regions
  /// @param match                   becomes kIsolated there
  /// @return                        pixels that stay matched
  int remove(int least_pixels, float* disparity_px, float* sigma_px, std::uint8_t* match);

 private:
  struct Run {
    int begin, end;  // pixels of the image
    int parent;      // the run that leads to the region's first one
    int pixels;      // of the region, in its first run
  };
  int first_of(int run);
  void join(int a, int b);

  ImageSize size_;
  std::vector<Run> runs_;
};

}  // namespace raybundle
