// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/matcher.hpp"

#include <cstdlib>
#include <string>
#include <vector>

#include "pyramid.hpp"
#include "require.hpp"

namespace raybundle {
namespace {

constexpr int kLeastSide = 16;
constexpr int kMostOfALevel = 256;
constexpr int kMostDisparities = 16384;  // such that places in the image fit into 16 bits

const MatchOptions& checked(ImageSize size, const MatchOptions& options) {
  require(options.coarse_levels >= 0 && options.coarse_levels <= 6, "the number of coarse levels is from 0 to 6");
  require(size.width >> options.coarse_levels >= kLeastSide && size.height >> options.coarse_levels >= kLeastSide,
          "images to be matched have at least 16x16 pixels, on the coarsest level, too");
  require(options.least_disparity >= 0 && options.least_disparity < size.width,
          "the least disparity is from 0 to the width of the image");
  require(options.disparities >= 1 && options.disparities <= kMostDisparities,
          "the number of disparities is from 1 to " + std::to_string(kMostDisparities));
  MatchOptions coarsest = options;
  for (int k = 0; k < options.coarse_levels; ++k) coarsest = halved(coarsest);
  require(coarsest.disparities <= kMostOfALevel, "the coarsest level has at most " + std::to_string(kMostOfALevel) +
                                                     " disparities, not " + std::to_string(coarsest.disparities) +
                                                     ": take more coarse levels, or fewer disparities");
  require(!options.mask.empty() && options.mask.size() <= 120, "a census mask has from 1 to 120 neighbours");
  for (const auto& [x, y] : options.mask) {
    require(std::abs(x) <= 15 && std::abs(y) <= 15, "the neighbours of a census mask are within 15 px");
  }
  require(options.window_px >= 1 && options.window_px <= 15 && options.window_px % 2 == 1,
          "the window's side is odd and at most 15 px");
  require(options.paths == 0 || options.paths == 3 || options.paths == 4, "costs are gathered along 0, 3 or 4 paths");
  require(options.small_step >= 0 && options.small_step <= options.large_step && options.large_step <= 1.5,
          "the costs of steps are from 0 to 1.5, the small one at most the large one");
  require(options.edge_grey > 0, "the step of grey values at an edge is above 0");
  require(options.noise_grey > 0, "the noise of grey values is above 0");
  return options;
}

}  // namespace

std::string_view match_name(Match match) {
  constexpr std::string_view kNames[kMatchKinds] = {"uncovered", "matched",   "weak",    "ambiguous",
                                                    "flat",      "one_sided", "isolated"};
  return kNames[static_cast<int>(match)];
}

struct Matcher::Data {
  std::vector<PyramidLevel> levels;
};

Matcher::Matcher(ImageSize size, const MatchOptions& options)
    : data_(std::make_unique<Data>(Data{pyramid(size, checked(size, options))})) {}
Matcher::~Matcher() = default;
Matcher::Matcher(Matcher&&) noexcept = default;
Matcher& Matcher::operator=(Matcher&&) noexcept = default;

DisparityView Matcher::match(GreyView left, GreyView right, const std::uint8_t* left_covered,
                             const std::uint8_t* right_covered) {
  std::vector<PyramidLevel>& levels = data_->levels;
  if (levels.size() > 1) levels[1].halve(left, right, left_covered, right_covered);
  for (std::size_t k = 2; k < levels.size(); ++k) {
    const PyramidLevel::Image &fine_left = levels[k - 1].left(), &fine_right = levels[k - 1].right();
    levels[k].halve(fine_left.view(), fine_right.view(), fine_left.covered.data(), fine_right.covered.data());
  }
  for (std::size_t k = levels.size(); k-- > 1;) {
    levels[k].search();
    levels[k - 1].search_around(levels[k]);
  }
  levels[0].search(left, right, left_covered, right_covered);
  return levels[0].found();
}

}  // namespace raybundle
