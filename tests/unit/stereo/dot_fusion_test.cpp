// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Laser dots on surfaces without texture: what is filled is right within its sigma, and nothing else is touched.
#include "raybundle/stereo/dot_fusion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/parameter_names.hpp"
#include "raybundle/stereo/rectification.hpp"
#include "raybundle/stereo/stereo.hpp"

namespace raybundle {
namespace {

constexpr ImageSize kSize{160, 120};
constexpr int kPixels = kSize.width * kSize.height;
constexpr int kSpacing = 12;
constexpr double kDotSigma = 0.1;

// A scene of one grey value, in which the matcher found nothing unless the test says so, and a grid of dots.
struct Scene {
  std::vector<std::uint8_t> grey = std::vector<std::uint8_t>(kPixels, 100);
  std::vector<float> disparity = std::vector<float>(kPixels, 0.0F);
  std::vector<float> sigma = std::vector<float>(kPixels, 0.15F);
  std::vector<std::uint8_t> match = std::vector<std::uint8_t>(kPixels, static_cast<std::uint8_t>(Match::kFlat));
  std::vector<AnchorDot> dots;

  void add_grid(const std::function<double(double, double)>& disparity_at, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (int v = 6; v < kSize.height; v += kSpacing) {
      for (int u = 6; u < kSize.width; u += kSpacing) {
        const double at_u = u + 0.5 * normal(random), at_v = v + 0.5 * normal(random);
        dots.push_back({at_u, at_v, disparity_at(at_u, at_v) + kDotSigma * normal(random), kDotSigma});
      }
    }
  }
  FusedView fused_by(DotFusion& fusion) const {
    const auto [width, height] = kSize;
    return fusion.fuse({grey.data(), width, height, width},
                       {{disparity.data(), width, height, width},
                        {sigma.data(), width, height, width},
                        {match.data(), width, height, width},
                        0},
                       dots);
  }
};

bool is_from(const FusedView& view, int i, DisparitySource source) {
  return view.source.pixels[i] == static_cast<std::uint8_t>(source);
}

// A pair, 0.1 m apart and turned.
Calibration two_cameras() {
  const Camera camera = start_camera(*model_named("pinhole"), kSize, 100.0);
  RigCamera left{"left", camera, {}}, right{"right", camera, {}};
  right.camera_from_rig.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, 3).normalized());
  right.camera_from_rig.translation = right.camera_from_rig.rotation * Eigen::Vector3d(-0.1, 0.002, 0.001);
  Calibration calibration;
  calibration.cameras = {left, right};
  return calibration;
}

// The same, rectified to either projection.
Rectification pair_of(RectifiedProjection projection) {
  const Calibration calibration = two_cameras();
  return rectify(calibration.cameras[0], calibration.cameras[1], {.projection = projection});
}

// Its sigma is the spread of the disparities of points that scatter along the ray.
TEST(AnchorDot, IsWhereBothRectifiedImagesShowThePoint) {
  for (const auto projection : {RectifiedProjection::kPinhole, RectifiedProjection::kTransverseEquirectangular}) {
    const Rectification pair = pair_of(projection);
    const Eigen::Vector3d x_in_left(0.1, -0.05, 0.8), ray = x_in_left.normalized();
    constexpr double kSigma_m = 0.004;
    const Eigen::Matrix3d covariance = kSigma_m * kSigma_m * ray * ray.transpose();
    const auto disparity = [&](const Eigen::Vector3d& x) {
      const Eigen::Vector3d in_left = pair.rectified_from_left * x;
      const auto left = pair.camera.pixel_from_ray(in_left);
      const auto right = pair.camera.pixel_from_ray(in_left - pair.baseline_m * Eigen::Vector3d::UnitX());
      return left->x() - right->x();
    };
    const auto dot = anchor_dot(pair, x_in_left, covariance);
    ASSERT_TRUE(dot);
    const Eigen::Vector2d pixel = *pair.camera.pixel_from_ray(pair.rectified_from_left * x_in_left);
    EXPECT_EQ(Eigen::Vector2d(dot->u_px, dot->v_px), pixel);
    EXPECT_NEAR(dot->disparity_px, disparity(x_in_left), 1e-9);
    const double slope = (disparity(x_in_left - kSigma_m * ray) - disparity(x_in_left + kSigma_m * ray)) / 2;
    EXPECT_NEAR(dot->sigma_px, slope, 1e-3 * slope);  // both are differences, of 0.5 % and 0.1 % of the distance
    EXPECT_FALSE(anchor_dot(pair, -x_in_left, covariance));
  }
}

// What is uncertain of the pair takes part twice, where a distance becomes a disparity and where that becomes a distance
// again: it cancels.
TEST(StereoMatcher, SigmaOfWhatDotsFillIsThatOfTheDotsAlone) {
  const std::vector<std::uint8_t> grey(kPixels, 100);
  const GreyView flat{grey.data(), kSize.width, kSize.height, kSize.width};
  for (const auto projection : {RectifiedProjection::kPinhole, RectifiedProjection::kTransverseEquirectangular}) {
    Calibration calibration = two_cameras();
    StereoOptions options;
    options.rectify.projection = projection;
    options.dots.emplace();
    StereoMatcher sure(calibration, "left", "right", options);
    calibration.covariance = {extrinsic_names("right"), 1e-4 * Eigen::MatrixXd::Identity(6, 6)};
    StereoMatcher unsure(calibration, "left", "right", options);
    ASSERT_GT(unsure.calibration_sigma_px(), 0.5);
    const Rectification& pair = sure.rectification();
    std::vector<AnchorDot> dots;
    for (int v = 6; v < pair.camera.size.height; v += kSpacing) {
      for (int u = 6; u < pair.camera.size.width; u += kSpacing) {
        dots.push_back({1.0 * u, 1.0 * v, disparity_from_distance(pair.camera, pair.baseline_m, u, 0.8), kDotSigma});
      }
    }
    const StereoFrame a = sure.process(flat, flat, dots), b = unsure.process(flat, flat, dots);
    ASSERT_GT(a.fused.filled, 1000);
    for (int i = 0; i < pair.camera.size.width * pair.camera.size.height; ++i) {
      ASSERT_EQ(a.points.pixels[i].sigma_m, b.points.pixels[i].sigma_m) << i;
    }
  }
}

double slanted(double u, double v) { return 20.0 + 0.05 * u - 0.03 * v; }

TEST(DotFusion, FillsASlantedPlaneWithinItsSigma) {
  DotFusion fusion(kSize);
  double sum2 = 0.0, error2 = 0.0;
  int filled = 0, beyond = 0, inside = 0, inside_filled = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene scene;
    scene.add_grid(slanted, seed);
    const FusedView view = scene.fused_by(fusion);
    for (int i = 0; i < kPixels; ++i) {
      const int u = i % kSize.width, v = i / kSize.width;
      const bool within = u > 8 && v > 8 && u < 147 && v < 111;
      inside += within;
      if (!is_from(view, i, DisparitySource::kDots)) continue;
      inside_filled += within;
      const double error = view.disparity_px.pixels[i] - slanted(u, v);
      const double in_sigmas = error / view.sigma_px.pixels[i];
      sum2 += in_sigmas * in_sigmas;
      error2 += error * error;
      beyond += std::abs(in_sigmas) > 3.0;
      ++filled;
    }
  }
  EXPECT_GT(inside_filled, 0.9 * inside);
  EXPECT_LT(std::sqrt(error2 / filled), kDotSigma);
  // sigma is on the safe side: planes share dots, and real surfaces bend
  EXPECT_LT(std::sqrt(sum2 / filled), 1.1);
  EXPECT_GT(std::sqrt(sum2 / filled), 0.3);
  EXPECT_LT(beyond, 0.005 * filled);
}

TEST(DotFusion, SigmaGrowsWithTheDistanceFromTheDots) {
  Scene scene;
  for (int v = 20; v <= 100; v += 40) {
    for (int u = 20; u <= 140; u += 40) {
      scene.dots.push_back({1.0 * u, 1.0 * v, 20.0, kDotSigma});
    }
  }
  DotFusion fusion(kSize);
  const FusedView view = scene.fused_by(fusion);
  ASSERT_GT(view.filled, 0);
  EXPECT_GT(view.sigma_px.at(80, 80), view.sigma_px.at(61, 61) * 1.2F);
}

struct EachStep : ::testing::TestWithParam<double> {};

TEST_P(EachStep, AStepInDepthIsNotBridged) {
  const auto step = [](double u, double) { return u < 67.0 ? 10.0 : 10.0 + GetParam(); };
  Scene scene;
  scene.add_grid(step, 3);
  DotFusion fusion(kSize);
  const FusedView view = scene.fused_by(fusion);
  int filled = 0;
  for (int i = 0; i < kPixels; ++i) {
    if (!is_from(view, i, DisparitySource::kDots)) continue;
    ++filled;
    // on either side, never between: within a third of the step
    const double value = view.disparity_px.pixels[i];
    EXPECT_LT(std::min(std::abs(value - 10.0), std::abs(value - 10.0 - GetParam())), GetParam() / 3.0)
        << i % kSize.width << ' ' << i / kSize.width;
  }
  EXPECT_GT(filled, kPixels / 2);
}

INSTANTIATE_TEST_SUITE_P(Steps, EachStep, ::testing::Values(2.0, 6.0, 20.0));

TEST(DotFusion, WithoutDotsNothingChanges) {
  Scene scene;
  std::mt19937 random(5);
  for (int i = 0; i < kPixels; ++i) {
    scene.match[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(random() % kMatchKinds);
    const bool matched = scene.match[static_cast<std::size_t>(i)] == static_cast<std::uint8_t>(Match::kMatched);
    scene.disparity[static_cast<std::size_t>(i)] = matched ? static_cast<float>(random() % 10000) / 177.0F : 0.0F;
  }
  DotFusion fusion(kSize);
  Scene before;
  before.add_grid(slanted, 1);
  before.fused_by(fusion);  // nothing of an earlier frame stays
  const FusedView view = scene.fused_by(fusion);
  EXPECT_EQ(view.filled + view.contradicted, 0);
  for (int i = 0; i < kPixels; ++i) {
    const auto at = static_cast<std::size_t>(i);
    ASSERT_EQ(view.disparity_px.pixels[i], scene.disparity[at]);
    const bool matched = scene.match[at] == static_cast<std::uint8_t>(Match::kMatched);
    ASSERT_EQ(is_from(view, i, DisparitySource::kMatched), matched);
  }
}

TEST(DotFusion, MatchesStayUnlessADotOnThemContradicts) {
  Scene scene;
  scene.add_grid(slanted, 2);
  int wrong = 0;
  for (int i = 0; i < kPixels; ++i) {
    const int u = i % kSize.width, v = i / kSize.width;
    const bool is_wrong = u >= 50 && u < 80 && v >= 50 && v < 80;  // as a repeated pattern would
    wrong += is_wrong;
    scene.match[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(Match::kMatched);
    scene.disparity[static_cast<std::size_t>(i)] = static_cast<float>(slanted(u, v) + (is_wrong ? 8.0 : 0.0));
  }
  DotFusion fusion(kSize);
  const FusedView view = scene.fused_by(fusion);
  EXPECT_EQ(view.filled, 0);
  EXPECT_GT(view.contradicted, 0);
  for (int i = 0; i < kPixels; ++i) {
    const int u = i % kSize.width, v = i / kSize.width;
    if (is_from(view, i, DisparitySource::kContradicted)) {
      EXPECT_TRUE(u >= 50 && u < 80 && v >= 50 && v < 80);
      EXPECT_EQ(view.disparity_px.pixels[i], 0.0F);
    } else {
      EXPECT_EQ(view.disparity_px.pixels[i], scene.disparity[static_cast<std::size_t>(i)]);
    }
  }
}

// What all matches may be off by contradicts none of them.
TEST(DotFusion, ACalibrationThatMayBeOffIsNotContradicted) {
  Scene scene;
  scene.add_grid(slanted, 2);
  for (int i = 0; i < kPixels; ++i) {
    scene.match[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(Match::kMatched);
    scene.disparity[static_cast<std::size_t>(i)] = static_cast<float>(slanted(i % kSize.width, i / kSize.width) + 2.0);
  }
  DotFusion sure(kSize), unsure(kSize, {}, std::vector<float>(kPixels, 1.0F));
  EXPECT_GT(scene.fused_by(sure).contradicted, 0);
  EXPECT_EQ(scene.fused_by(unsure).contradicted, 0);
}

TEST(DotFusion, AWronglyLabelledDotLeavesAHoleAndNoWrongDepth) {
  Scene scene;
  scene.add_grid(slanted, 4);
  scene.dots[scene.dots.size() / 2 + 5].disparity_px += 9.0;
  DotFusion fusion(kSize);
  const FusedView view = scene.fused_by(fusion);
  EXPECT_GT(view.filled, kPixels / 2);
  for (int i = 0; i < kPixels; ++i) {
    if (!is_from(view, i, DisparitySource::kDots)) continue;
    EXPECT_LT(std::abs(view.disparity_px.pixels[i] - slanted(i % kSize.width, i / kSize.width)), 1.0);
  }
}

TEST(DotFusion, AnObjectOfAnotherGreyIsNotFilled) {
  Scene scene;
  scene.add_grid(slanted, 6);
  const std::size_t at = 60 * kSize.width + 70;
  scene.grey[at] = 200;
  DotFusion fusion(kSize);
  const FusedView view = scene.fused_by(fusion);
  EXPECT_TRUE(is_from(view, static_cast<int>(at), DisparitySource::kNone));
  EXPECT_TRUE(is_from(view, static_cast<int>(at) + 1, DisparitySource::kDots));
}

TEST(DotFusion, LeavesOutDotsThatCannotBe) {
  Scene scene;
  scene.dots = {{-5.0, 3.0, 10.0, 0.1},
                {1e9, 3.0, 10.0, 0.1},
                {5.0, NAN, 10.0, 0.1},
                {5.0, 5.0, NAN, 0.1},
                {5.0, 5.0, 10.0, 0.0}};
  DotFusion fusion(kSize);
  EXPECT_EQ(scene.fused_by(fusion).filled, 0);
  EXPECT_THROW(DotFusion({0, 0}), Error);
}

}  // namespace
}  // namespace raybundle
