// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../targets/src/saddle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

namespace raybundle {
namespace {

/// Four sectors around `centre`, edges at two angles; supersampled, blurred, noisy.
cv::Mat corner_image(const Eigen::Vector2d& centre, double angle_a, double angle_b, double noise_grey, unsigned seed) {
  cv::Mat image(41, 41, CV_32F);
  constexpr int kSamples = 8;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      double sum = 0;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const double dx = x + (s % kSamples + 0.5) / kSamples - 0.5 - centre.x();
        const double dy = y + (s / kSamples + 0.5) / kSamples - 0.5 - centre.y();
        const double side_a = std::cos(angle_a) * dy - std::sin(angle_a) * dx;
        const double side_b = std::cos(angle_b) * dy - std::sin(angle_b) * dx;
        sum += side_a * side_b < 0 ? 200 : 40;  // clockwise from a to b is bright
      }
      image.at<float>(y, x) = static_cast<float>(sum / (kSamples * kSamples));
    }
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, 1);
  cv::Mat grey(image.size(), CV_8U);
  for (int i = 0; i < 41 * 41; ++i) {
    grey.data[i] = cv::saturate_cast<uchar>(image.at<float>(i) + static_cast<float>(noise_grey) * noise(random));
  }
  return grey;
}

TEST(Saddle, RoundWindowFindsPlaceEdgesAndPolarity) {
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector2d centre(20 + 0.08 * k, 20.3 - 0.06 * k);
    const double angle_a = 0.5 * k + 0.17;  // never along the rows, where the samples would be seen
    const double angle_b = angle_a + 1.2;
    const auto saddle = refine_saddle(corner_image(centre, angle_a, angle_b, 0, 1), {20.5, 19.5}, 7);
    ASSERT_TRUE(saddle);
    EXPECT_LT((saddle->pixel - centre).norm(), 0.02);  // 8-bit rounding and the pixels' box
    const double turn = std::abs(saddle->edge_a.x() * std::sin(angle_a) - saddle->edge_a.y() * std::cos(angle_a));
    EXPECT_LT(turn, 0.02);
    // Clockwise from a to b through the bright sector: neither swapped nor turned the other way.
    EXPECT_GT(saddle->edge_a.x() * saddle->edge_b.y() - saddle->edge_a.y() * saddle->edge_b.x(), 0.8);
    EXPECT_NEAR(saddle->contrast, 160, 8);
  }
}

TEST(Saddle, LatticeWindowTellsPolarityOnItsOwn) {
  const cv::Mat image = corner_image({20.2, 19.7}, 0.1, 1.5, 0, 1);
  SaddleWindow window;
  window.half_x = {0.2, 7};  // along edge b
  window.half_y = {-7, -0.4};
  const auto saddle = refine_saddle(image, {19, 20.5}, window);
  ASSERT_TRUE(saddle);
  EXPECT_LT((saddle->pixel - Eigen::Vector2d(20.2, 19.7)).norm(), 0.02);
  EXPECT_GT(std::abs(saddle->edge_a.x()), 0.95);
}

// 200 noisy copies: the scatter is what sigma says, within a fifth.
TEST(Saddle, SigmaIsTheScatterUnderNoise) {
  const Eigen::Vector2d centre(20.37, 19.81);
  double squares = 0, variances = 0;
  int n = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const auto saddle = refine_saddle(corner_image(centre, 0.3, 1.7, 10, seed), {20, 20}, 6);
    ASSERT_TRUE(saddle);
    squares += 0.5 * (saddle->pixel - centre).squaredNorm();
    variances += saddle->sigma_px * saddle->sigma_px;
    ++n;
  }
  EXPECT_NEAR(std::sqrt(squares / variances), 1.0, 0.2);
}

TEST(Saddle, WhatIsNoSaddleIsRefused) {
  cv::Mat flat(41, 41, CV_8U, cv::Scalar(120));
  EXPECT_FALSE(refine_saddle(flat, {20, 20}, 7));
  cv::Mat edge = flat.clone();
  edge.colRange(20, 41).setTo(20);
  EXPECT_FALSE(refine_saddle(edge, {20, 20}, 7));
  cv::Mat square_corner = flat.clone();  // an outer corner of a board: three sectors bright
  square_corner(cv::Rect(20, 20, 21, 21)).setTo(20);
  SaddleWindow window{{7, 0}, {0, 7}};
  EXPECT_FALSE(refine_saddle(square_corner, {20, 20}, 7));
  EXPECT_FALSE(refine_saddle(square_corner, {20, 20}, window));
  EXPECT_FALSE(refine_saddle(flat, {0, 0}, 7));
  EXPECT_FALSE(refine_saddle(flat, {-50, 1e9}, 7));
}

}  // namespace
}  // namespace raybundle
