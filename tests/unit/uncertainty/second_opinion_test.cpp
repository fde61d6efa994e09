// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/second_opinion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raybundle/calibrate/calibrate.hpp"
#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

bool without_mrcal(const std::vector<SecondOpinion>& opinions) {
  return opinions[0].why_not.find("has no mrcal") != std::string::npos;
}

// A narrower lens in a model that mrcal has too.
SyntheticOptions opencv_options(const std::string& model, int cameras) {
  SyntheticOptions options = stereo_options(4);
  for (SyntheticCamera& camera : options.cameras) {
    camera.model = model;
    camera.focal_px = 700.0;
  }
  options.cameras.resize(static_cast<std::size_t>(cameras));
  options.max_off_axis_rad = 0.5;
  options.frames = 12;
  return options;
}

// The bar of a second opinion: projections equal within 0.02 px over the field that corners covered.
class SecondOpinionOf : public ::testing::TestWithParam<std::tuple<std::string, int>> {};

TEST_P(SecondOpinionOf, EqualsTheFirst) {
  const auto [model, cameras] = GetParam();
  const SyntheticWorld world = synthetic_world(opencv_options(model, cameras));
  const CalibrationResult first = calibrate(world.problem);
  const std::vector<SecondOpinion> opinions = second_opinions(world.problem, first);
  if (without_mrcal(opinions)) GTEST_SKIP() << opinions[0].why_not;
  const SecondOpinion& second = opinions[0];
  ASSERT_TRUE(second.comparison) << second.why_not;
  EXPECT_THAT(second.source, HasSubstr("LENSMODEL_OPENCV"));
  // Our prior of a rational lens leaves the corners the noise that mrcal's lens follows: 8 parameters of 1300 values.
  EXPECT_NEAR(second.rms_px, first.rms_px, (first.lens_priors.empty() ? 1e-4 : 0.01) * first.rms_px);
  for (const ProjectionDifference& difference : second.comparison->projections) {
    EXPECT_LT(difference.largest_px, 0.02) << difference.camera;
  }
  for (const NormalizedDifference& extrinsic : second.comparison->extrinsics) EXPECT_LT(extrinsic.sigmas, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Models, SecondOpinionOf,
                         ::testing::Values(std::tuple("brown_conrady", 1), std::tuple("brown_conrady", 2),
                                           std::tuple("rational", 1)));

// Corners without noise leave nothing between a fisheye and its splined opinion but how well a regularised spline
// follows the lens, which the opinion states and takes out; a thousandth of a pixel is what is left of two solves.
TEST(SplinedOpinion, FollowsAFisheyeAsNearlyAsItSays) {
  SyntheticOptions options;
  options.frames = 40;
  options.max_off_axis_rad = 1.2;  // boards reach 75° off the axis: a field of 150°
  const SyntheticWorld world = synthetic_world(options);
  const CalibrationResult first = calibrate(world.problem);
  const std::vector<SecondOpinion> opinions = second_opinions(world.problem, first);
  if (without_mrcal(opinions)) GTEST_SKIP() << opinions[0].why_not;
  ASSERT_EQ(opinions.size(), 2u);
  EXPECT_THAT(opinions[0].why_not, HasSubstr("no model like kannala_brandt"));
  const SecondOpinion& splined = opinions[1];
  ASSERT_TRUE(splined.comparison) << splined.why_not;
  ASSERT_TRUE(splined.approximation_px);
  EXPECT_LT(splined.comparison->projections[0].largest_px, 1e-3);
  EXPECT_LT(*splined.approximation_px, 0.5);
  EXPECT_GT(splined.comparison->projections[0].covered_share, 0.5);
}

// A lens that is bent by what its model lacks shows in the splined opinion, and only there: the one of the same model
// goes wrong with it.
TEST(SplinedOpinion, SeesWhatTheModelLacks) {
  SyntheticOptions options = opencv_options("rational", 1);
  options.frames = 30;
  const SyntheticWorld world = synthetic_world(options);
  CalibrationProblem simpler = world.problem;
  simpler.cameras[0].model = *model_named("pinhole");
  const CalibrationResult first = calibrate(simpler);
  const std::vector<SecondOpinion> opinions = second_opinions(simpler, first);
  if (without_mrcal(opinions)) GTEST_SKIP() << opinions[0].why_not;
  ASSERT_TRUE(opinions[1].comparison) << opinions[1].why_not;
  EXPECT_LT(opinions[1].rms_px, 0.5 * first.rms_px);
  EXPECT_GT(opinions[1].comparison->projections[0].largest_px, 2.0);
}

TEST(SecondOpinion, SaysWhyThereIsNone) {
  const SyntheticWorld world = synthetic_world(fisheye_options(1));
  CalibrationProblem ruled = world.problem;
  ruled.rules.push_back({"*.k1", ParameterRule::Kind::kFixed, 0.0});
  CalibrationResult first;
  first.calibration = solved_from_truth(world);
  const std::vector<SecondOpinion> opinions = second_opinions(ruled, first);
  ASSERT_EQ(opinions.size(), 1u);
  EXPECT_FALSE(opinions[0].comparison);
  EXPECT_THAT(opinions[0].why_not, AnyOf(HasSubstr("are fixed or have priors"), HasSubstr("has no mrcal")));
}

}  // namespace
}  // namespace raybundle::testing
