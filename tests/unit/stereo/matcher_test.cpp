// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The matcher held against a slow one that is written down as the method is described, and against itself.
#include "raybundle/stereo/matcher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
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

// Sums along five paths and the disparity of the least one, straight from the definition.
std::vector<int> slow_disparities(const Pair& pair, const MatchOptions& options) {
  const auto [width, height] = pair.left.size;
  const int count = options.disparities;
  constexpr int bit_cost = 2;  // of a mask of 24
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
        costs[index(u, v, d)] = bit_cost * differing;
      }
    }
  }
  const int most = bit_cost * static_cast<int>(options.mask.size());
  const int small_step = static_cast<int>(std::lround(options.small_step * most));
  const int large_step = static_cast<int>(std::lround(options.large_step * most));
  constexpr std::array<std::array<int, 2>, 5> kBefore{{{-1, 0}, {0, -1}, {-1, -1}, {1, -1}, {1, 0}}};
  std::vector<int> sums(costs.size(), 0);
  for (const auto& [x, y] : kBefore) {
    std::vector<int> path(costs.size(), 0);
    for (int v = 0; v < height; ++v) {
      for (int i = 0; i < width; ++i) {
        const int u = x > 0 && y == 0 ? width - 1 - i : i;
        const bool starts = u + x < 0 || u + x >= width || v + y < 0;
        int least = std::numeric_limits<int>::max();
        for (int d = 0; d < count; ++d) {
          int way = 0;
          if (!starts) {
            const auto before = [&](int e) { return path[index(u + x, v + y, e)]; };
            way = std::min(before(d), large_step);
            if (d > 0) way = std::min(way, before(d - 1) + small_step);
            if (d + 1 < count) way = std::min(way, before(d + 1) + small_step);
          }
          path[index(u, v, d)] = costs[index(u, v, d)] + way;
          least = std::min(least, path[index(u, v, d)]);
        }
        for (int d = 0; d < count; ++d) sums[index(u, v, d)] += path[index(u, v, d)] -= least;
      }
    }
  }
  std::vector<int> best;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto begin = sums.begin() + static_cast<std::ptrdiff_t>(index(u, v, 0));
      best.push_back(static_cast<int>(std::min_element(begin, begin + count) - begin) + options.least_disparity);
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
  MatchOptions options = this->options();
  options.window_px = 1;  // averages are rounded: the definition has none
  options.uniqueness = 0.0;
  options.least_region_px = 0;
  Matcher matcher(GetParam().size, options);
  const DisparityView view = matcher.match(pair.left.view(), pair.right.view());
  const std::vector<int> expected = slow_disparities(pair, options);
  int compared = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (view.match.pixels[i] != static_cast<std::uint8_t>(Match::kMatched)) continue;
    ASSERT_LE(std::abs(view.disparity_px.pixels[i] - static_cast<float>(expected[i])), 0.501F)
        << i;  // the rest is sub-pixel
    ++compared;
  }
  EXPECT_GT(compared, static_cast<int>(expected.size()) / 2);
}

TEST_P(EachSize, AllInstructionsGiveTheSameBits) {
  const Pair pair = textured_pair(GetParam().size, 6);
  MatchOptions options = this->options();
  Matcher fast(GetParam().size, options);
  options.simd = Simd::kNone;
  Matcher plain(GetParam().size, options);
  const DisparityView a = fast.match(pair.left.view(), pair.right.view());
  const DisparityView b = plain.match(pair.left.view(), pair.right.view());
  EXPECT_EQ(a.matched, b.matched);
  EXPECT_GT(a.matched, 0);
  const std::size_t count = static_cast<std::size_t>(GetParam().size.width) * GetParam().size.height;
  for (std::size_t i = 0; i < count; ++i) {
    ASSERT_EQ(a.disparity_px.pixels[i], b.disparity_px.pixels[i]);
    ASSERT_EQ(a.match.pixels[i], b.match.pixels[i]);
  }
}

TEST_P(EachSize, TheSecondCallKnowsNothingOfTheFirst) {
  const Pair pair = textured_pair(GetParam().size, 7);
  const Pair other = textured_pair(GetParam().size, 8);
  Matcher matcher(GetParam().size, options());
  const auto copy = [](const DisparityView& view) {
    return std::vector<float>(view.disparity_px.pixels,
                              view.disparity_px.pixels + view.disparity_px.width * view.disparity_px.height);
  };
  const std::vector<float> first = copy(matcher.match(pair.left.view(), pair.right.view()));
  matcher.match(other.left.view(), other.right.view());
  EXPECT_EQ(copy(matcher.match(pair.left.view(), pair.right.view())), first);
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
