// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/comparison.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "raybundle/geometry/error.hpp"
#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;

// Mean of the squared difference over the squared sigma that it should have, cell by cell.
double mean_square_in_sigmas(const ProjectionDifference& difference) {
  double sum = 0.0;
  int cells = 0;
  for (Eigen::Index i = 0; i < difference.u_px.size(); ++i) {
    const double u = difference.u_px.data()[i], v = difference.v_px.data()[i];
    if (!std::isfinite(u)) continue;
    sum += (u * u + v * v) / std::pow(difference.sigma_px.data()[i], 2);
    ++cells;
  }
  return sum / cells;
}

TEST(Comparison, OfACalibrationWithItselfFindsNothing) {
  const Calibration a = solved_from_truth(synthetic_world(stereo_options(1)));
  const CalibrationComparison comparison = compare(a, a, {.ranges_m = {1.0, kInfinitelyFar}});
  ASSERT_EQ(comparison.projections.size(), 4u);
  for (const ProjectionDifference& difference : comparison.projections) {
    EXPECT_LT(difference.largest_px, 1e-9);
    EXPECT_EQ(difference.share_within, 1.0);
    EXPECT_GT(difference.covered_share, 0.3);
  }
  ASSERT_EQ(comparison.extrinsics.size(), 6u);
  EXPECT_EQ(comparison.extrinsics[0].name, "camera1.camera_from_rig.rotation_x");
  EXPECT_EQ(comparison.extrinsics[0].sigmas, 0.0);
}

// A camera that is turned in its body, its frame with it, sees the same: no image tells.
TEST(Comparison, TakesOutARotation) {
  Calibration a = solved_from_truth(synthetic_world(fisheye_options(1)));
  Calibration b = a;
  b.cameras[0].camera.parameters[2] += 1.0;  // a shift of the principal point is nearly a rotation
  const ProjectionDifference difference = compare(a, b).projections[0];
  EXPECT_NEAR(angle_between(difference.b_from_a, {}), 1.0 / 380.0, 0.3 / 380.0);
  EXPECT_LT(difference.rms_px, 0.5);
  EXPECT_EQ(difference.b_from_a.translation.norm(), 0.0);
}

// Two samples of the same noise differ by what the sigmas say. The sum of two equal sigmas squared is twice their
// variances' sum, and two directions share it: the mean square is at most 1, about 0.7 for typical ellipses.
TEST(Comparison, OfTwoSamplesStaysWithinTheirSigmas) {
  constexpr int kPairs = 25;
  double sum = 0.0, share = 0.0;
  for (unsigned pair = 1; pair <= kPairs; ++pair) {
    const Calibration a = solved_from_truth(synthetic_world(fisheye_options(2 * pair)));
    const Calibration b = solved_from_truth(synthetic_world(fisheye_options(2 * pair + 1)));
    const ProjectionDifference difference = compare(a, b).projections[0];
    sum += mean_square_in_sigmas(difference);
    share += difference.share_within;
  }
  EXPECT_GT(sum / kPairs, 0.45);
  EXPECT_LT(sum / kPairs, 1.1);
  EXPECT_GT(share / kPairs, 0.95);
}

TEST(Comparison, SeesALensThatHasChanged) {
  const Calibration a = solved_from_truth(synthetic_world(fisheye_options(1)));
  Calibration b = a;
  b.cameras[0].camera.parameters[0] *= 1.01;
  EXPECT_FALSE(compare(a, b).agrees());
}

// A lens that folds at 74 degrees, amid the corners of the other one: what only one of them sees differs, however
// little is known of either.
TEST(Comparison, CountsWhatOnlyOneLensSees) {
  const Calibration a = solved_from_truth(synthetic_world(fisheye_options(1)));
  EXPECT_EQ(compare(a, a).projections[0].lost_share, 0.0);
  Calibration b = a;
  b.cameras[0].camera.parameters.tail<4>() << -0.2, 0.0, 0.0, 0.0;
  b.covariance.matrix *= 1e12;
  for (const auto& comparison : {compare(a, b), compare(b, a)}) {
    const ProjectionDifference& difference = comparison.projections[0];
    EXPECT_GT(difference.lost_share, 0.1);
    EXPECT_EQ(difference.share_within, 1.0 - difference.lost_share);
    EXPECT_FALSE(comparison.agrees());
  }
}

// A lens in another model, of which nothing is uncertain: both are held against each other all the same.
TEST(Comparison, ModelsMayDiffer) {
  const Calibration a = solved_from_truth(synthetic_world(fisheye_options(1)));
  Calibration b = a;
  b.cameras[0].camera = start_camera(*model_named("field_of_view"), {1280, 960}, 380.0);
  b.cameras[0].evidence->implied_motion.setZero(6, b.cameras[0].camera.parameters.size());
  b.covariance = {{}, Eigen::MatrixXd(0, 0)};
  const ProjectionDifference difference = compare(a, b).projections[0];
  EXPECT_GT(difference.rms_px, 0.1);
  EXPECT_TRUE(std::isfinite(difference.largest_px));
  EXPECT_FALSE(difference.agrees());
}

TEST(Comparison, NormalizesExtrinsicsAndBeams) {
  Calibration a = solved_from_truth(synthetic_world(stereo_options(1)));
  LaserPattern pattern{{1, 2}, {}, {}, 0.0, 0.0};
  LaserBeam beam{0, 1, {{0.1, 0.0, 1.0}, Eigen::Vector3d::UnitZ()}};
  beam.covariance = Eigen::Vector4d(1e-8, 1e-8, 1e-8, 1e-8).asDiagonal();
  pattern.beams = {beam};
  a.laser = pattern;
  Calibration b = a;
  b.cameras[1].camera_from_rig.translation.x() += 1e-3;
  b.laser->beams[0].line.point += Eigen::Vector3d(2e-4, 0.0, 0.5);  // along the beam nothing moves
  const CalibrationComparison comparison = compare(a, b);
  const NormalizedDifference& moved = comparison.extrinsics[3];
  EXPECT_EQ(moved.name, "camera1.camera_from_rig.translation_x");
  EXPECT_NEAR(moved.sigmas, 1e-3 / (std::sqrt(2.0) * a.covariance.sigma(moved.name)), 1e-6 * moved.sigmas);
  ASSERT_EQ(comparison.beams.size(), 1u);
  EXPECT_NEAR(comparison.beams[0].difference, 2e-4, 1e-12);
  // Variance of an offset: 1e-8 of a, and 1e-8 (1 + 0.5²) of b half a metre farther; the slopes agree, but are
  // correlated with b's offsets.
  Eigen::Matrix2d offset_and_slope{{2.25e-8, -0.5e-8}, {-0.5e-8, 2e-8}};
  const double whitened = 4e-8 * offset_and_slope.inverse()(0, 0);
  EXPECT_NEAR(comparison.beams[0].sigmas, std::sqrt(whitened / 4.0), 1e-9);
  EXPECT_TRUE(comparison.not_compared.empty());

  b.laser->beams[0].line.direction = -Eigen::Vector3d::UnitZ();
  EXPECT_EQ(compare(a, b).beams.at(0).sigmas, std::numeric_limits<double>::infinity());
  b.laser->beams.clear();
  EXPECT_THAT(compare(a, b).not_compared,
              ::testing::ElementsAre(HasSubstr("of 1 beams in the one and 0 in the other")));
  b.laser.reset();
  EXPECT_THAT(compare(b, a).not_compared, ::testing::ElementsAre(HasSubstr("a laser is in the second")));
}

TEST(Comparison, WhatIsHeldMayNotDiffer) {
  Calibration a = solved_from_truth(synthetic_world(stereo_options(1)));
  a.covariance = {};
  Calibration b = a;
  b.cameras[1].camera_from_rig.translation.x() += 0.5;
  const std::vector<NormalizedDifference> extrinsics = compare(a, b).extrinsics;
  EXPECT_EQ(extrinsics.at(3).sigmas, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(extrinsics.at(4).sigmas));

  LaserPattern pattern{{1, 2}, {}, {}, 0.0, 0.0};
  pattern.beams = {LaserBeam{0, 1, {{0.1, 0.0, 1.0}, Eigen::Vector3d::UnitZ()}}};
  a.laser = b.laser = pattern;
  EXPECT_TRUE(std::isnan(compare(a, b).beams.at(0).sigmas));
  b.laser->beams[0].line.point.x() += 0.5;
  EXPECT_EQ(compare(a, b).beams.at(0).sigmas, std::numeric_limits<double>::infinity());
}

// A truth was not solved from corners: it is compared where those of the other calibration were.
TEST(Comparison, TakesThePlacesOfCornersFromWhicheverTellsThem) {
  const Calibration solved = solved_from_truth(synthetic_world(fisheye_options(1)));
  Calibration truth = solved;
  truth.cameras[0].evidence.reset();
  truth.covariance = {};
  const double covered_share = compare(solved, solved).projections[0].covered_share;
  for (const auto& comparison : {compare(truth, solved), compare(solved, truth)}) {
    EXPECT_LT(comparison.projections.at(0).largest_px, 1e-9);
    EXPECT_EQ(comparison.projections[0].covered_share, covered_share);
    EXPECT_THAT(comparison.remarks, ::testing::Contains(HasSubstr("does not tell where the corners")));
  }
  EXPECT_THROW(compare(truth, truth), Error);
}

TEST(Comparison, SaysWhatItCannotCompare) {
  const Calibration a = solved_from_truth(synthetic_world(stereo_options(1)));
  Calibration b = a;
  b.cameras[0].name = "another";
  const CalibrationComparison comparison = compare(a, b);
  EXPECT_EQ(comparison.projections.size(), 1u);
  EXPECT_TRUE(comparison.extrinsics.empty());
  EXPECT_THAT(comparison.not_compared, ::testing::Contains(HasSubstr("rig frames")));
  EXPECT_THAT(comparison.not_compared, ::testing::Contains(HasSubstr("another is in the second calibration only")));
  b.cameras[1].camera.size.width += 1;
  EXPECT_THROW(compare(a, b), Error);
  b.cameras.pop_back();
  EXPECT_THROW(compare(a, b), Error);
  EXPECT_THROW(compare(a, a, {.sigmas_from = SigmasFrom::kFrames}), Error);
}

}  // namespace
}  // namespace raybundle::testing
