// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/second_opinion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/uncertainty/comparison.hpp"
#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;

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
  const SecondOpinion second = second_opinion(world.problem, first);
  if (second.why_not.find("has no mrcal") != std::string::npos) GTEST_SKIP() << second.why_not;
  ASSERT_TRUE(second.calibration) << second.why_not;
  EXPECT_THAT(second.source, HasSubstr("LENSMODEL_OPENCV"));
  EXPECT_NEAR(second.rms_px, first.rms_px, 1e-4 * first.rms_px);
  const CalibrationComparison comparison = compare(second.counterpart, *second.calibration);
  for (const ProjectionDifference& difference : comparison.projections) {
    EXPECT_LT(difference.largest_px, 0.02) << difference.camera;
  }
  for (const NormalizedDifference& extrinsic : comparison.extrinsics) EXPECT_LT(extrinsic.sigmas, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Models, SecondOpinionOf,
                         ::testing::Values(std::tuple("brown_conrady", 1), std::tuple("brown_conrady", 2),
                                           std::tuple("rational", 1)));

TEST(SecondOpinion, SaysWhyThereIsNone) {
  const SyntheticWorld world = synthetic_world(fisheye_options(1));
  CalibrationResult first;
  first.calibration = solved_from_truth(world);
  const SecondOpinion second = second_opinion(world.problem, first);
  EXPECT_FALSE(second.calibration);
  EXPECT_THAT(second.why_not, ::testing::AnyOf(HasSubstr("no model like kannala_brandt"), HasSubstr("has no mrcal")));
}

}  // namespace
}  // namespace raybundle::testing
