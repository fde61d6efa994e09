// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "aligned.hpp"
#include "match_costs.hpp"
#include "raybundle/stereo/matcher.hpp"
#include "row_kernels.hpp"

namespace raybundle {

/// Finds the best disparity of each pixel among `disparities` from the pixel's first one on, and judges it.
class Search {
 public:
  Search(ImageSize size, const MatchOptions& options);

  /// @param disparity_px  becomes the disparity, 0 where there is no match; width × height
  /// @param sigma_px      becomes its standard deviation, 0 where there is no match
  /// @param match         becomes the Match of each pixel
  void run(const SearchedPair& pair, const std::uint8_t* left_covered, float* disparity_px, float* sigma_px,
           std::uint8_t* match);

  /// Of each row of the last pair: the pixels that were searched.
  std::span<const Extent> extents() const { return extents_; }

 private:
  using Bytes = std::vector<std::uint8_t>;

  BestRow best_row() {
    return {best_.data(),      least_sum_.data(), second_.data(), sum_before_.data(),
            sum_after_.data(), before_.data(),    cost_.data(),   after_.data()};
  }
  Extent extent(int v) const { return extents_[static_cast<std::size_t>(v)]; }
  PathRow path_row(const std::uint8_t* costs, int v);
  void steps_of(const SearchedPair& pair, int v, int before);
  void gather_down(const SearchedPair& pair, int v);
  void gather_up(const SearchedPair& pair, int v);
  void find_agreeing(Extent extent, const std::int16_t* first, const std::uint8_t* right_covered);
  void judge_row(int v, const SearchedPair& pair, const std::uint8_t* left_covered, float* disparity_px,
                 float* sigma_px, std::uint8_t* match);

  MatchOptions options_;
  ImageSize size_;
  int lanes_;
  const RowKernels& kernels_;
  std::unique_ptr<MatchCosts> costs_;
  std::vector<Extent> extents_;                  // of the rows that are searched
  std::array<RepeatedByte, 256> large_steps_{};  // by the step of grey values
  std::uint8_t small_step_;
  int uniqueness_limit_, strength_limit_, peak_limit_;
  std::vector<RepeatedByte> large_across_, large_along_;
  Columns from_left_, from_right_, along_, along_before_;
  Columns all_costs_, all_sums_;  // of the image, for paths from below
  Bytes best_, least_sum_, second_, sum_before_, sum_after_, before_, cost_, after_;  // of a row, as BestRow
  Bytes all_covered_, agrees_;
  std::vector<std::uint32_t> right_;  // the same row seen from the right image: sum · 65536 + disparity
};

}  // namespace raybundle
