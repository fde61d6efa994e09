// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The matcher held against a slow one that is written down as the method is described, and against itself.
#include "raybundle/stereo/matcher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

struct Image {
  ImageSize size;
  std::vector<std::uint8_t> pixels;
  GreyView view() const { return {pixels.data(), size.width, size.height, size.width}; }
  // Pixels of the border repeat outside of it.
  int at(int u, int v) const {
    return pixels[static_cast<std::size_t>(std::clamp(v, 0, size.height - 1)) * size.width +
                  std::clamp(u, 0, size.width - 1)];
  }
};

// Texture that is shifted by a disparity which changes from row to row and in the middle of each row, with noise.
struct Pair {
  Image left, right;
};
Pair textured_pair(ImageSize size, unsigned seed) {
  std::mt19937 random(seed);
  Pair pair{{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.width) * size.height)}, {}};
  pair.right = pair.left;
  for (auto& pixel : pair.right.pixels) pixel = static_cast<std::uint8_t>(random() % 200 + 20);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const int disparity = 4 + v / 8 + (u > size.width / 2 ? 5 : 0);
      pair.left.pixels[static_cast<std::size_t>(v) * size.width + u] =
          static_cast<std::uint8_t>(pair.right.at(u - disparity, v) + static_cast<int>(random() % 9));
    }
  }
  return pair;
}

// What a fisheye covers of a rectified image: nothing in the corners.
using Mask = std::vector<std::uint8_t>;
Mask ellipse(ImageSize size) {
  Mask covered(static_cast<std::size_t>(size.width) * size.height);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double x = 2.0 * u / (size.width - 1) - 1, y = 2.0 * v / (size.height - 1) - 1;
      covered[static_cast<std::size_t>(v) * size.width + u] = x * x + y * y <= 1.0;
    }
  }
  return covered;
}

// What a step of disparity costs along a path: less where the grey values jump.
int large_step(const Pair& pair, const MatchOptions& options, int most, int u, int v, int from_u, int from_v) {
  const double edge = 1.0 + std::abs(pair.left.at(u, v) - pair.left.at(from_u, from_v)) / options.edge_grey;
  return static_cast<int>(
      std::lround(std::max(std::round(options.small_step * most) + 1, options.large_step * most / edge)));
}

// Sums along the paths and the disparity of the least one, straight from the definition. Disparities up to the next
// size of columns take part, but are never best. Paths begin where the image is covered.
std::vector<int> slow_disparities(const Pair& pair, const MatchOptions& options, const Mask& covered) {
  const auto [width, height] = pair.left.size;
  int count = 256;
  for (const int lanes : {192, 128, 96, 64, 32}) count = options.disparities <= lanes ? lanes : count;
  const int bit_cost = 255 / static_cast<int>(options.mask.size());
  const auto index = [&](int u, int v, int d) { return (static_cast<std::size_t>(v) * width + u) * count + d; };
  std::vector<int> costs(index(0, height, 0));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      for (int d = 0; d < count; ++d) {
        const int right = u - d - options.least_disparity;
        int differing = 0;
        for (const auto& [x, y] : options.mask) {
          const bool in_left = pair.left.at(u + x, v + y) >= pair.left.at(u, v);
          const bool in_right = pair.right.at(right + x, v + y) >= pair.right.at(right, v);
          differing += right < 0 || in_left != in_right;
        }
        costs[index(u, v, d)] = bit_cost * differing / 4;  // paths count in units of four
      }
    }
  }
  const double most = bit_cost * static_cast<double>(options.mask.size()) / 4;
  const int small_step = static_cast<int>(std::lround(options.small_step * most));
  std::vector<std::array<int, 2>> from{{-1, 0}, {1, 0}, {0, -1}};
  if (options.paths == 4) from.push_back({0, 1});
  std::vector<int> sums(costs.size(), 0);
  for (const auto& [x, y] : from) {
    std::vector<int> path(costs.size(), 0);
    for (int j = 0; j < height; ++j) {
      const int v = y > 0 ? height - 1 - j : j;
      for (int i = 0; i < width; ++i) {
        const int u = x > 0 ? width - 1 - i : i;
        const bool starts = u + x < 0 || u + x >= width || v + y < 0 || v + y >= height ||
                            covered[static_cast<std::size_t>(v + y) * width + u + x] == 0;
        int least = 0;
        if (!starts) {
          const auto begin = path.begin() + static_cast<std::ptrdiff_t>(index(u + x, v + y, 0));
          least = *std::min_element(begin, begin + count);
        }
        for (int d = 0; d < count; ++d) {
          int way = 0;
          if (!starts) {
            const auto before = [&](int e) { return path[index(u + x, v + y, e)] - least; };
            way = std::min(before(d), large_step(pair, options, static_cast<int>(most), u, v, u + x, v + y));
            if (d > 0) way = std::min(way, before(d - 1) + small_step);
            if (d + 1 < count) way = std::min(way, before(d + 1) + small_step);
          }
          path[index(u, v, d)] = costs[index(u, v, d)] + way;
          sums[index(u, v, d)] += path[index(u, v, d)];
        }
      }
    }
  }
  std::vector<int> best;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto begin = sums.begin() + static_cast<std::ptrdiff_t>(index(u, v, 0));
      best.push_back(static_cast<int>(std::min_element(begin, begin + options.disparities) - begin) +
                     options.least_disparity);
    }
  }
  return best;
}

struct Case {
  ImageSize size;
  int disparities;
  int least_disparity;
};

struct EachSize : testing::TestWithParam<Case> {
  MatchOptions options() const {
    MatchOptions options;
    options.disparities = GetParam().disparities;
    options.least_disparity = GetParam().least_disparity;
    return options;
  }
};

TEST_P(EachSize, TheBestDisparityIsTheOneOfTheDefinition) {
  const Pair pair = textured_pair(GetParam().size, 5);
  const Mask all(pair.left.pixels.size(), 1), round = ellipse(GetParam().size);
  for (const auto& [paths, covered] :
       {std::pair(3, &all), std::pair(4, &all), std::pair(3, &round), std::pair(4, &round)}) {
    MatchOptions options = this->options();
    options.paths = paths;
    options.window_px = 1;
    options.uniqueness = 0.0;
    options.left_right_px = -1;
    options.least_region_px = 0;
    options.refine = false;
    Matcher matcher(GetParam().size, options);
    const DisparityView view = matcher.match(pair.left.view(), pair.right.view(), covered->data());
    const std::vector<int> expected = slow_disparities(pair, options, *covered);
    int compared = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (view.match.pixels[i] != static_cast<std::uint8_t>(Match::kMatched)) continue;
      ASSERT_LE(std::abs(view.disparity_px.pixels[i] - static_cast<float>(expected[i])), 0.501F)
          << i;  // the rest is sub-pixel
      ++compared;
    }
    EXPECT_GT(compared, std::accumulate(covered->begin(), covered->end(), 0) * 2 / 5);
  }
}

std::vector<float> disparities_of(const Pair& pair, const MatchOptions& options,
                                  const std::uint8_t* covered = nullptr) {
  Matcher matcher(pair.left.size, options);
  const DisparityView view = matcher.match(pair.left.view(), pair.right.view(), covered, covered);
  return {view.disparity_px.pixels, view.disparity_px.pixels + view.disparity_px.width * view.disparity_px.height};
}

std::vector<float> sigmas_of(const Pair& pair, const MatchOptions& options, const std::uint8_t* covered = nullptr) {
  Matcher matcher(pair.left.size, options);
  const DisparityView view = matcher.match(pair.left.view(), pair.right.view(), covered, covered);
  return {view.sigma_px.pixels, view.sigma_px.pixels + view.sigma_px.width * view.sigma_px.height};
}

// All costs, windows whose sums fit into bytes and such whose do not, paths and levels.
std::vector<MatchOptions> many_options(const MatchOptions& base) {
  std::vector<MatchOptions> all;
  for (const MatchCost cost : kMatchCosts) {
    for (const int window_px : {1, 5, 9}) {
      all.push_back(base);
      all.back().cost = cost;
      all.back().window_px = window_px;
    }
  }
  for (const int paths : {0, 4}) {
    all.push_back(base);
    all.back().paths = paths;
  }
  all.push_back(base);
  all.back().mask = sparse_census(11);
  return all;
}

TEST_P(EachSize, AllInstructionsGiveTheSameBits) {
  const Pair pair = textured_pair(GetParam().size, 6);
  const Mask mask = ellipse(GetParam().size);
  for (MatchOptions options : many_options(this->options())) {
    SCOPED_TRACE(std::string(match_cost_name(options.cost)) + " window " + std::to_string(options.window_px));
    options.simd = Simd::kNone;
    const std::vector<float> plain = disparities_of(pair, options), round = disparities_of(pair, options, mask.data());
    const std::vector<float> sigmas = sigmas_of(pair, options);
    if (!has(Simd::kAvx2)) continue;
    options.simd = Simd::kAvx2;
    EXPECT_EQ(plain, disparities_of(pair, options));
    EXPECT_EQ(round, disparities_of(pair, options, mask.data()));
    EXPECT_EQ(sigmas, sigmas_of(pair, options));
  }
}

TEST_P(EachSize, TheSecondCallKnowsNothingOfTheFirst) {
  const Pair pair = textured_pair(GetParam().size, 7);
  const Pair other = textured_pair(GetParam().size, 8);
  const Mask round = ellipse(GetParam().size);
  for (const MatchOptions& options : many_options(this->options())) {
    for (const std::uint8_t* covered : {static_cast<const std::uint8_t*>(nullptr), round.data()}) {
      Matcher matcher(GetParam().size, options);
      matcher.match(other.left.view(), other.right.view());
      const DisparityView view = matcher.match(pair.left.view(), pair.right.view(), covered, covered);
      EXPECT_TRUE(std::ranges::equal(disparities_of(pair, options, covered),
                                     std::span(view.disparity_px.pixels, pair.left.pixels.size())));
      EXPECT_TRUE(std::ranges::equal(sigmas_of(pair, options, covered),
                                     std::span(view.sigma_px.pixels, pair.left.pixels.size())));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, EachSize,
                         testing::Values(Case{{64, 48}, 32, 0}, Case{{97, 33}, 20, 0}, Case{{70, 40}, 64, 0},
                                         Case{{130, 40}, 96, 0}, Case{{120, 30}, 65, 2}, Case{{90, 30}, 31, 3},
                                         Case{{220, 24}, 150, 0}, Case{{300, 20}, 256, 0}));

TEST(Matcher, SaysWhatIsWrongWithItsOptions) {
  MatchOptions options;
  options.disparities = 0;
  EXPECT_THROW(Matcher({64, 64}, options), Error);
  options = {};
  options.mask.clear();
  EXPECT_THROW(Matcher({64, 64}, options), Error);
  EXPECT_THROW(Matcher({4, 64}, MatchOptions{}), Error);
  options = {};  // 2021, 1013, 509, 257
  options.disparities = 2021;
  options.least_disparity = 7;
  options.coarse_levels = 3;
  EXPECT_THROW(Matcher({640, 480}, options), Error);
  options.disparities = 2010;  // 2010, 1007, 506, 256
  EXPECT_NO_THROW(Matcher({640, 480}, options));
}

// The right image as another camera would see it.
Pair seen_as(Pair pair, double gain, double offset, double gamma) {
  for (auto& pixel : pair.right.pixels) {
    pixel = static_cast<std::uint8_t>(std::lround(offset + gain * 110.0 * std::pow(pixel / 110.0, gamma)));
  }
  return pair;
}

// Right pixels of few, small and even grey values, so that no change of brightness rounds two of them together.
Pair coarse_pair() {
  Pair pair = textured_pair({96, 48}, 12);
  for (Image* image : {&pair.left, &pair.right}) {
    for (auto& pixel : image->pixels) pixel = static_cast<std::uint8_t>(pixel / 8 * 4);
  }
  return pair;
}

TEST(MatchCost, CensusDoesNotChangeWithAnyBrightnessCurve) {
  const Pair pair = coarse_pair();
  const MatchOptions options{.disparities = 32, .refine = false};
  EXPECT_EQ(disparities_of(pair, options), disparities_of(seen_as(pair, 1.5, 20.0, 0.8), options));
}

TEST(MatchCost, ZnccDoesNotChangeWithGainAndOffset) {
  const Pair pair = coarse_pair();
  const MatchOptions options{.disparities = 32, .cost = MatchCost::kZncc, .refine = false};
  // A factor of two: then floats round the same way.
  EXPECT_EQ(disparities_of(pair, options), disparities_of(seen_as(pair, 2.0, 5.0, 1.0), options));
}

TEST(MatchCost, SsdIsForEqualBrightness) {
  const Pair pair = coarse_pair();
  const MatchOptions options{.disparities = 32, .cost = MatchCost::kSsd};
  EXPECT_NE(disparities_of(pair, options), disparities_of(seen_as(pair, 2.0, 5.0, 1.0), options));
}

TEST(MatchCost, EachFindsTexture) {
  const Pair pair = textured_pair({120, 64}, 13);
  for (const MatchCost cost : kMatchCosts) {
    const std::vector<float> found = disparities_of(pair, {.disparities = 32, .cost = cost});
    int right = 0;
    for (int v = 0; v < 64; ++v) {
      for (int u = 32; u < 120; ++u) {
        const double truth = 4 + v / 8 + (u > 60 ? 5 : 0);
        right += std::abs(found[static_cast<std::size_t>(v) * 120 + u] - truth) < 1;
      }
    }
    EXPECT_GT(right, 64 * 88 * 7 / 10) << match_cost_name(cost);
  }
}

// A ramp of disparities that 32 do not hold: the coarse levels find where to search.
TEST(Matcher, FindsFromCoarseToFineWhatTheWholeSearchFinds) {
  constexpr ImageSize kSize{360, 64};
  Pair pair = textured_pair(kSize, 14);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      pair.left.pixels[static_cast<std::size_t>(v) * kSize.width + u] =
          static_cast<std::uint8_t>((pair.right.at(u - 20 - u / 6, v) + pair.right.at(u + 1 - 20 - u / 6, v)) / 2);
    }
  }
  MatchOptions options{.disparities = 100};
  const std::vector<float> whole = disparities_of(pair, options);
  for (const int levels : {1, 2}) {
    options.coarse_levels = levels;
    const std::vector<float> found = disparities_of(pair, options);
    int both = 0, same = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!(whole[i] > 0) || !(found[i] > 0)) continue;
      ++both;
      same += std::abs(whole[i] - found[i]) <= 1;
    }
    EXPECT_GT(both, kSize.width * kSize.height / 2) << levels;
    EXPECT_GT(same, both * 99 / 100) << levels;
  }
}

// A covered or saturated camera: costs are the same at every disparity, and what paths carry in from the rim is no
// match.
TEST(Matcher, WhereOneImageHasNoTextureNothingIsMatched) {
  const Pair textured = textured_pair({160, 64}, 10);
  const std::vector<std::uint8_t> even(textured.left.pixels.size(), 255);
  const Image blank{textured.left.size, even};
  for (const auto& [left, right] :
       {std::pair(&blank, &blank), std::pair(&textured.left, &blank), std::pair(&blank, &textured.right)}) {
    for (MatchOptions options : many_options({.disparities = 32})) {
      for (const int least : {0, 3}) {
        options.least_disparity = least;
        Matcher matcher({160, 64}, options);
        EXPECT_EQ(matcher.match(left->view(), right->view()).matched, 0)
            << match_cost_name(options.cost) << " window " << options.window_px << " paths " << options.paths
            << " from " << least;
      }
    }
  }
  Matcher matcher({160, 64}, {.disparities = 32});
  const DisparityView view = matcher.match(blank.view(), blank.view());
  EXPECT_EQ(view.match.at(100, 32), static_cast<std::uint8_t>(Match::kFlat));
}

TEST(Matcher, PixelsWithoutASourceAreNeverMatched) {
  const Pair pair = textured_pair({96, 64}, 9);
  std::vector<std::uint8_t> covered(96 * 64, 1);
  for (int v = 0; v < 64; ++v) std::fill_n(covered.begin() + v * 96, 30, std::uint8_t{0});
  Matcher matcher({96, 64}, {.disparities = 20});
  const DisparityView view = matcher.match(pair.left.view(), pair.right.view(), covered.data(), covered.data());
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 96; ++u) {
      if (view.match.at(u, v) != static_cast<std::uint8_t>(Match::kMatched)) continue;
      EXPECT_GE(static_cast<float>(u) - view.disparity_px.at(u, v), 29.5F);
    }
  }
  EXPECT_GT(view.matched, 1000);
}

}  // namespace
}  // namespace raybundle
