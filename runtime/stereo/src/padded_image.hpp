// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "byte_lanes.hpp"
#include "raybundle/camera/camera.hpp"
#include "raybundle/device/image_view.hpp"
#include "raybundle/stereo/extent.hpp"

namespace raybundle {

/// A copy of an image with a rim in which the pixels of the border repeat, so that windows may reach beyond it. Rows
/// can be read up to the next multiple of kLanes pixels.
class PaddedImage {
 public:
  PaddedImage(ImageSize size, int rim_px)
      : size_(size),
        rim_(rim_px),
        stride_((size.width + 2 * rim_px) / kLanes * kLanes + 2 * kLanes),
        pixels_(static_cast<std::size_t>(stride_) * (size.height + 2 * rim_px)) {}

  std::ptrdiff_t stride() const { return stride_; }

  /// Row -rim to height - 1 + rim; columns -rim to width - 1 + rim of it may be read.
  const std::uint8_t* row(int v) const { return pixels_.data() + (v + rim_) * stride_ + rim_; }

  /// @param mirrored  the columns are taken in reverse order
  void fill(GreyView image, bool mirrored) {
    for (int v = -rim_; v < size_.height + rim_; ++v) {
      const std::uint8_t* from = image.row(std::clamp(v, 0, size_.height - 1));
      std::uint8_t* to = pixels_.data() + (v + rim_) * stride_ + rim_;
      if (mirrored) {
        std::reverse_copy(from, from + size_.width, to);
      } else {
        std::copy_n(from, size_.width, to);
      }
      std::fill_n(to - rim_, rim_, to[0]);
      std::fill_n(to + size_.width, rim_, to[size_.width - 1]);
    }
  }

  /// Repeats the outermost covered pixels of a row beyond them: what is not covered is black, and no edge of the scene.
  void repeat_beyond(int v, Extent covered) {
    if (covered.begin >= covered.end) return;
    std::uint8_t* to = pixels_.data() + (v + rim_) * stride_ + rim_;
    std::fill(to - rim_, to + covered.begin, to[covered.begin]);
    std::fill(to + covered.end, to + size_.width + rim_, to[covered.end - 1]);
  }

 private:
  ImageSize size_;
  int rim_;
  std::ptrdiff_t stride_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace raybundle
