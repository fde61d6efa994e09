// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "padded_image.hpp"
#include "raybundle/stereo/match_options.hpp"
#include "row_kernels.hpp"

namespace raybundle {

/// Matching costs of one row after the other: differing census bits, averaged over the window.
class CensusCosts {
 public:
  CensusCosts(ImageSize size, int lanes, const MatchOptions& options, const RowKernels& kernels);

  /// Cost of pixels that have nothing in common.
  int most() const { return most_; }

  /// Starts a pair of images.
  void begin(GreyView left, GreyView right);

  /// Costs of a row, which must be the one behind the last one.
  ///
  /// @param right_covered  mask of the right image, or nullptr
  /// @return               width columns, valid until the next call
  const std::uint8_t* row(int v, const std::uint8_t* right_covered);

 private:
  std::uint8_t* raw(int v) { return raw_[static_cast<std::size_t>((v + 3) % 3)].data(); }
  void fill_raw(int v, const std::uint8_t* right_covered);

  ImageSize size_;
  int lanes_, planes_, least_disparity_, window_px_, most_;
  std::ptrdiff_t plane_stride_;
  const RowKernels& kernels_;
  PaddedImage left_, right_;  // the right one is mirrored
  std::vector<std::ptrdiff_t> left_offsets_, right_offsets_;
  std::array<std::uint8_t, 16> nibble_costs_{};
  std::vector<std::uint8_t> left_codes_, right_codes_, right_limits_, smooth_;
  std::array<std::vector<std::uint8_t>, 3> raw_;  // of the rows above, here and below
};

}  // namespace raybundle
