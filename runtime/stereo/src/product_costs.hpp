// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "match_costs.hpp"

namespace raybundle {

/// Squared differences of grey values, or their correlation without mean and contrast (ZNCC), over the window.
class ProductCosts : public MatchCosts {
 public:
  ProductCosts(ImageSize size, int lanes, const MatchOptions& options, const RowKernels& kernels);

  int most() const override;
  void begin(const SearchedPair& pair, std::span<const Extent> extents) override;
  const std::uint8_t* row(int v) override;

 private:
  void move(int v, bool enters);
  void sum_left(int v);

  ImageSize size_;
  int lanes_, radius_;
  bool correlation_;
  const RowKernels& kernels_;
  SearchedPair pair_;
  std::span<const Extent> extents_;
  RightLimits limits_;
  std::vector<std::vector<std::uint8_t>> right_;  // mirrored rows of the window, and of the row that leaves it
  std::vector<std::int32_t> sums_, window_;
  std::vector<std::int32_t> left_columns_, left_column_squares_, left_sums_, left_squares_;
  std::vector<std::uint8_t> costs_;
};

}  // namespace raybundle
