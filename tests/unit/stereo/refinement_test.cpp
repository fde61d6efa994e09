// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Disparities between whole pixels, and what is said of their errors, on images as cameras take them: blurred edges
// between faces that have hardly any texture, another gain and offset of the right camera, and noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/stereo/matcher.hpp"

namespace raybundle {
namespace {

constexpr int kWidth = 240, kHeight = 120, kTile = 16, kDisparities = 32;

// Tiles of random grey, leaning, and a faint texture over them; blurred by 0.7 px.
class Mosaic {
 public:
  explicit Mosaic(unsigned seed) : greys_(64 * 64), grain_(1024 * 256) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    for (float& grey : greys_) grey = 40.0F + static_cast<float>(random() % 170);
    for (float& grain : grain_) grain = 4.0F * normal(random);
    double sum = 0.0;
    for (std::size_t i = 0; i < kernel_.size(); ++i) {
      const double x = kStep * (static_cast<double>(i) - kReach);
      sum += kernel_[i] = std::exp(-x * x / (2 * 0.7 * 0.7));
    }
    for (double& weight : kernel_) weight /= sum;
  }
  double at(double u, double v) const {
    double sum = 0.0;
    for (std::size_t j = 0; j < kernel_.size(); ++j) {
      for (std::size_t i = 0; i < kernel_.size(); ++i) {
        const double x = kStep * (static_cast<double>(i) - kReach), y = kStep * (static_cast<double>(j) - kReach);
        sum += kernel_[i] * kernel_[j] * sharp(u + x, v + y);
      }
    }
    return sum;
  }

 private:
  double sharp(double u, double v) const {
    const auto at = [](double value, double step) { return static_cast<unsigned>(std::floor(value / step) + 1024); };
    const unsigned tile = at(v - 0.2 * u, kTile) % 64 * 64 + at(u + 0.3 * v, kTile) % 64;
    return greys_[tile] + grain_[at(v, 2.0) % 256 * 1024 + at(u, 2.0) % 1024];
  }
  static constexpr double kStep = 0.2;
  static constexpr int kReach = 9;
  std::vector<float> greys_, grain_;
  std::array<double, 2 * kReach + 1> kernel_{};
};

// 1.4826 times the median of what is left of the sign: the standard deviation of Gaussian values about 0.
double spread(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return 1.4826 * median(values);
}

// Both images of grainy faces: blurred noise about a middle grey, so weak that noise is not far below it.
struct Grainy {
  Grainy(double grey_rms, double middle_grey, unsigned seed) : middle_grey_(middle_grey) {
    constexpr double kBlur_px = 1.2;
    constexpr int kReach = 6 * kFine;
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<double> sharp(kRow * kHeight + 2 * kReach + 1);
    for (double& value : sharp) value = normal(random);
    double squares = 0.0;
    for (std::size_t i = 0; i < fine_.size(); ++i) {
      for (int k = -kReach; k <= kReach; ++k) {
        const double x = static_cast<double>(k) / kFine;
        fine_[i] += std::exp(-x * x / (2 * kBlur_px * kBlur_px)) * sharp[i + static_cast<std::size_t>(k + kReach)];
      }
      squares += fine_[i] * fine_[i];
    }
    for (double& value : fine_) value *= grey_rms / std::sqrt(squares / static_cast<double>(fine_.size()));
  }
  double at(double u, int v) const {  // linear between samples
    const double place = kFine * (u + kRim) + kRow * v, whole = std::floor(place);
    const auto i = static_cast<std::size_t>(whole);
    return middle_grey_ + (1 - (place - whole)) * fine_[i] + (place - whole) * fine_[i + 1];
  }

 private:
  static constexpr int kFine = 4, kRim = 32, kRow = kFine * (kWidth + 2 * kRim);  // samples of a pixel, of a row
  double middle_grey_;
  std::vector<double> fine_ = std::vector<double>(kRow * kHeight + 1);
};

struct Found {
  std::vector<double> disparities_px, errors_px, in_sigmas, sigmas_px;
  std::vector<int> columns, rows;
};

// How the cameras see a scene: the right one with a gain and an offset, both with noise, the left one from a column on.
struct Seen {
  double gain = 1.0, offset = 0.0, noise_grey = 1.0;
  int covered_from = 0;
};

// What is matched of `scene`, whose points are `disparity_px(u, v)` apart.
template <typename Scene, typename Disparity>
Found matched(const Scene& scene, const Disparity& disparity_px, const Seen& seen, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto byte = [&](double grey) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(grey + seen.noise_grey * normal(random)), 0L, 255L));
  };
  std::vector<std::uint8_t> left, right, covered;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      covered.push_back(u >= seen.covered_from);
      left.push_back(u >= seen.covered_from ? byte(scene.at(u - disparity_px(u, v), v)) : 0);
      right.push_back(byte(seen.gain * scene.at(u, v) + seen.offset));
    }
  }
  Matcher matcher({kWidth, kHeight}, {.disparities = kDisparities, .noise_grey = seen.noise_grey});
  const DisparityView view =
      matcher.match({left.data(), kWidth, kHeight, kWidth}, {right.data(), kWidth, kHeight, kWidth}, covered.data());
  Found found;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = std::max(kDisparities, seen.covered_from); u < kWidth - 4; ++u) {
      const double disparity = view.disparity_px.at(u, v), sigma = view.sigma_px.at(u, v);
      EXPECT_EQ(disparity > 0, sigma > 0);
      if (!(disparity > 0)) continue;
      found.disparities_px.push_back(disparity);
      found.errors_px.push_back(disparity - disparity_px(u, v));
      found.in_sigmas.push_back(found.errors_px.back() / sigma);
      found.sigmas_px.push_back(sigma);
      found.columns.push_back(u);
      found.rows.push_back(v);
    }
  }
  return found;
}

struct Refinement : testing::TestWithParam<Seen> {};

TEST_P(Refinement, DisparitiesLieWhereTheyAreAndSigmaSaysHowWell) {
  const Found found = matched(
      Mosaic(3), [](int u, int v) { return 12.0 + 0.015 * (u - 120) + 0.01 * (v - 60); }, GetParam(), 4);
  const std::size_t count = found.errors_px.size();
  ASSERT_GT(count, kWidth * kHeight / 2);
  std::size_t at_half = 0;
  std::vector<double> sure_errors_px;
  for (std::size_t i = 0; i < count; ++i) {
    at_half += found.disparities_px[i] - std::floor(found.disparities_px[i]) == 0.5;
    if (found.sigmas_px[i] < 0.15) sure_errors_px.push_back(found.errors_px[i]);
  }
  EXPECT_LT(static_cast<double>(at_half), 0.02 * static_cast<double>(count));
  EXPECT_GT(spread(found.in_sigmas), 0.6);
  EXPECT_LT(spread(found.in_sigmas), 1.5);
  ASSERT_GT(sure_errors_px.size(), count / 20);
  EXPECT_LT(spread(sure_errors_px), 0.15);
}

INSTANTIATE_TEST_SUITE_P(Cameras, Refinement,
                         testing::Values(Seen{}, Seen{.gain = 0.85, .offset = 12.0}, Seen{.gain = 0.5, .offset = 60.0},
                                         Seen{.noise_grey = 3.0}));

// Noise that is in the right image's slope and in its grey value, too, would pull by 0.1 px.
TEST(RefinementOfWeakTexture, IsNotPulledToHalfPixels) {
  for (const double fraction : {0.1, 0.25, 0.75, 0.9}) {
    const Found found = matched(
        Grainy(3.0, 120.0, 5), [&](int, int) { return 12.0 + fraction; }, {}, 6);
    ASSERT_GT(found.errors_px.size(), kWidth * kHeight / 4);
    const double mean = std::accumulate(found.errors_px.begin(), found.errors_px.end(), 0.0) /
                        static_cast<double>(found.errors_px.size());
    EXPECT_NEAR(mean, 0.0, 0.05) << fraction;
  }
}

// Far above near, and near above far: windows over the step are not averaged across it.
TEST(RefinementAtSteps, KeepsBothDepths) {
  for (const bool far_above : {true, false}) {
    const auto depth = [&](int, int v) { return (v < kHeight / 2) == far_above ? 1.2 : 9.0; };
    const Found found = matched(Grainy(12.0, 120.0, 7), depth, {}, 8);
    int beside = 0, between = 0;
    for (std::size_t i = 0; i < found.rows.size(); ++i) {
      if (std::abs(found.rows[i] + 0.5 - kHeight / 2.0) > 4) continue;
      ++beside;
      const double error = std::abs(found.errors_px[i]);
      between += error > 0.8 && error < 7.0;  // neither depth
    }
    ASSERT_GT(beside, kWidth);
    EXPECT_LT(between, 0.02 * beside) << far_above;
  }
}

// What is not covered is black, which is no edge of the scene.
TEST(RefinementAtRims, TakesNoBlackForTexture) {
  constexpr int kFrom = 60;
  const Found found = matched(
      Grainy(6.0, 120.0, 9), [](int, int) { return 12.3; }, {.covered_from = kFrom}, 10);
  std::vector<double> at_rim;
  for (std::size_t i = 0; i < found.columns.size(); ++i) {
    if (found.columns[i] < kFrom + 5) at_rim.push_back(found.in_sigmas[i]);
  }
  ASSERT_GT(at_rim.size(), 100U);
  EXPECT_LT(spread(at_rim), 1.5);
}

TEST(RefinementOptions, NoiseIsAboveZero) { EXPECT_THROW(Matcher({64, 64}, {.noise_grey = 0.0}), Error); }

}  // namespace
}  // namespace raybundle
