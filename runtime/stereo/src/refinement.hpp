// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "padded_image.hpp"
#include "raybundle/camera/camera.hpp"
#include "raybundle/device/image_view.hpp"
#include "row_kernels.hpp"

namespace raybundle {

/// Refines disparities by grey values, and says how well these tell them.
///
/// One Gauss-Newton step from the mean disparity of a window (5x5 px), on left(x) - gain · right(x - d) - offset, with
/// the slope of both images, as one more measurement beside what the paths have found. The gain is that of the images,
/// the offset of the window. Its variance is that of least squares, noise / slope² (Cramér-Rao), where the residuals
/// beyond the noise count as one common to the window; what noise adds to slopes, and to their product with the
/// difference, is taken out. Windows over a step in depth are left as they are. Each pixel's difference is taken at the
/// mean disparity of its own window: what that misses shows in the residuals, not in the variance of least squares.
/// Source: Lucas and Kanade, An Iterative Image Registration Technique, IJCAI 1981, with the mean of both slopes.
class Refinement {
 public:
  /// @param noise_grey  standard deviation of a grey value
  Refinement(ImageSize size, double noise_grey, const RowKernels& kernels);

  /// @param extents       of each row: what the left image covers; beyond them nothing is matched
  /// @param right_covered  of the right image, width × height; null: all of it
  /// @param disparity_px  as the paths found it, 0 where there is no match; becomes refined
  /// @param sigma_px      its standard deviation, becomes that of what is refined
  void run(GreyView left, GreyView right, std::span<const Extent> extents, const std::uint8_t* right_covered,
           float* disparity_px, float* sigma_px);

 private:
  /// Rows of floats with a rim of zeros: `number` of them, or as many as a window has, the last ones of an image.
  class Rows {
   public:
    explicit Rows(int width, int number = kRefineSide)
        : number_(number), stride_(width + 2 * kRefineRadius), values_(static_cast<std::size_t>(stride_) * number) {}
    float* row(int v = 0) { return values_.data() + v % number_ * stride_ + kRefineRadius; }

   private:
    int number_;
    std::ptrdiff_t stride_;
    std::vector<float> values_;
  };
  /// What is summed over windows: a row of it, and rows of sums across.
  struct Sum {
    Rows values, across;
    explicit Sum(int width) : values(width, 1), across(width) {}
  };

  void add_across(Sum& sum, int v);
  RefineRows around(Sum& sum, int v);
  float gain(GreyView left, GreyView right, const float* disparity_px) const;
  void count(int v, const float* disparity_px);
  void differ(int v, float gain, const float* disparity_px);
  void refine(int v, float gain, float* disparity_px, float* sigma_px);
  std::ptrdiff_t first(int v) const { return static_cast<std::ptrdiff_t>(v) * size_.width; }
  Extent extent(int v) const { return extents_[static_cast<std::size_t>(v)]; }

  ImageSize size_;
  std::span<const Extent> extents_;
  float noise_;  // variance of a grey value
  const RowKernels& kernels_;
  PaddedImage left_, right_;
  Rows no_sums_, no_disparities_, number_, smoothed_px_;
  Sum count_, weighted_, slope_, difference_, slope2_, product_, difference2_;
  std::vector<std::int32_t> column_;
  std::vector<std::uint32_t> four_;
};

}  // namespace raybundle
