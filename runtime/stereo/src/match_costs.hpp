// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "padded_image.hpp"
#include "raybundle/stereo/match_options.hpp"
#include "row_kernels.hpp"

namespace raybundle {

/// A pair of rectified images, and where to search in it.
struct SearchedPair {
  GreyView left, right;
  const std::uint8_t* right_covered = nullptr;  ///< mask, or nullptr: all of it is
  ImageView<const std::int16_t> first;          ///< first disparity of each pixel, 0 to width - 1
};

/// Matching costs of one row after the other, over windows.
class MatchCosts {
 public:
  virtual ~MatchCosts() = default;

  /// Cost of pixels that have nothing in common, at most 255.
  virtual int most() const = 0;

  /// Starts a pair of images, which stay as they are until the last row.
  ///
  /// @param extents  of each row: the pixels to be matched
  virtual void begin(const SearchedPair& pair, std::span<const Extent> extents) = 0;

  /// Costs of a row, which must be the one behind the last one; width columns, of which those of the extent count;
  /// valid until the next call.
  virtual const std::uint8_t* row(int v) = 0;
};

std::unique_ptr<MatchCosts> match_costs(ImageSize size, int lanes, const MatchOptions& options,
                                        const RowKernels& kernels);

/// What each cost has to know of the right image: which of its pixels can be matched.
class RightLimits {
 public:
  RightLimits(int width, int lanes, int most)
      : width_(width), most_(static_cast<std::uint8_t>(most)), limits_(mirrored_length(width, lanes), most_) {}

  /// Values that a mirrored row has: partners of all pixels at all disparities that there can be.
  static std::size_t mirrored_length(int width, int lanes) {
    return 2 * static_cast<std::size_t>(width) + static_cast<std::size_t>(lanes);
  }

  void fill(int v, const std::uint8_t* right_covered) {
    for (int x = 0; x < width_; ++x) {
      const bool covered = right_covered == nullptr || right_covered[static_cast<std::ptrdiff_t>(v) * width_ + x] != 0;
      limits_[static_cast<std::size_t>(width_ - 1 - x)] = covered ? std::uint8_t{0} : most_;
    }
  }
  const std::uint8_t* mirrored() const { return limits_.data(); }

 private:
  int width_;
  std::uint8_t most_;
  std::vector<std::uint8_t> limits_;
};

}  // namespace raybundle
