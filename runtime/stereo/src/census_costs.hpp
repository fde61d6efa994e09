// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "aligned.hpp"
#include "match_costs.hpp"

namespace raybundle {

/// Census bits that differ, summed over the window.
class CensusCosts : public MatchCosts {
 public:
  CensusCosts(ImageSize size, int lanes, const MatchOptions& options, const RowKernels& kernels);

  int most() const override { return most_; }
  void begin(const SearchedPair& pair, std::span<const Extent> extents) override;
  const std::uint8_t* row(int v) override;

 private:
  std::uint8_t* bits(int v) { return bits_[static_cast<std::size_t>(v) % bits_.size()].data(); }
  Extent windows_over(int v) const;
  void fill_bits(int v);
  void enter(const std::uint8_t* enters, const std::uint8_t* leaves);

  ImageSize size_;
  int lanes_, planes_, radius_;
  int most_bits_;  // of a pixel
  bool wide_;      // sums over windows do not fit into bytes
  int most_;
  std::ptrdiff_t plane_stride_;
  const RowKernels& kernels_;
  SearchedPair pair_;
  std::span<const Extent> extents_;
  PaddedImage left_, right_;  // the right one is mirrored
  std::vector<std::ptrdiff_t> left_offsets_, right_offsets_;
  std::array<std::uint8_t, 16> nibble_costs_{};
  RightLimits limits_;
  std::vector<std::uint8_t> left_codes_, right_codes_;
  std::vector<Columns> bits_;  // of the window's rows, and of the one that leaves it
  Columns no_bits_, sums_, costs_;
  std::vector<std::uint16_t> wide_sums_, wide_window_;
};

}  // namespace raybundle
