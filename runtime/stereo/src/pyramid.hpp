// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "raybundle/stereo/matcher.hpp"
#include "refinement.hpp"
#include "regions.hpp"
#include "search.hpp"

namespace raybundle {

/// One size of coarse-to-fine matching: its images, its search, and what it found.
class PyramidLevel {
 public:
  /// @param coarser  the next level is one of half the size, which says where to search
  /// @param halved   its images are made by halve(), not given
  PyramidLevel(ImageSize size, const MatchOptions& options, bool coarser, bool halved);

  /// Half of a finer pair of images; a pixel is covered when all that it is made of are.
  void halve(GreyView left, GreyView right, const std::uint8_t* left_covered, const std::uint8_t* right_covered);

  /// Searches the halved pair.
  void search() { search(left_.view(), right_.view(), left_.covered.data(), right_.covered.data()); }
  void search(GreyView left, GreyView right, const std::uint8_t* left_covered, const std::uint8_t* right_covered);

  /// From here on the search is around what a level of half the size has found.
  void search_around(const PyramidLevel& coarser);

  struct Image {
    ImageSize size;
    std::vector<std::uint8_t> pixels, covered;
    GreyView view() const { return {pixels.data(), size.width, size.height, size.width}; }
  };
  const Image& left() const { return left_; }
  const Image& right() const { return right_; }
  DisparityView found() const;

 private:
  ImageSize size_;
  MatchOptions options_;
  int last_first_;  // the largest that a first disparity can be
  Search search_;
  SmallRegions regions_;
  std::optional<Refinement> refinement_;  // of the whole image: of the others the next one only asks where to search
  Image left_, right_;
  std::vector<std::int16_t> first_;
  std::vector<float> disparity_px_, sigma_px_;
  std::vector<std::uint8_t> match_;
  std::vector<float> guide_px_;  // a row
  int matched_ = 0;
};

/// The options of the next level, of half the size: its disparities reach as far, and one beyond the last, which is
/// never a match.
MatchOptions halved(MatchOptions options);

/// The levels of a matcher, the whole image first.
std::vector<PyramidLevel> pyramid(ImageSize size, const MatchOptions& options);

}  // namespace raybundle
