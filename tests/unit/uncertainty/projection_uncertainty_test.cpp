// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/projection_uncertainty.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "aligned_projection.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/uncertainty/corner_evidence.hpp"
#include "raybundle/uncertainty/covariance.hpp"
#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

class Projection : public ::testing::Test {
 protected:
  Projection() : world_(synthetic_world(fisheye_options(1))), solved_(solved_from_truth(world_)) {}

  const RigCamera& camera() const { return solved_.cameras[0]; }

  SyntheticWorld world_;
  Calibration solved_;
};

// The linear answer against a camera that is really changed and aligned: a millionth of a change leaves a relative
// error of that order.
TEST_F(Projection, FollowsTheAlignedProjectionOfAChangedCamera) {
  const std::vector<TrueCorner> corners = true_corners(world_, 0);
  RigCamera truth{camera().name, world_.cameras[0], {}, corner_evidence(world_.problem, true_state(world_), 0)};
  const Eigen::VectorXd change = 1e-5 * (Eigen::VectorXd(8) << 300, -200, 100, 50, 1, -1, 2, -3).finished();
  Covariance one{solved_.covariance.names, change * change.transpose()};  // the only way to change
  Camera changed = truth.camera;
  changed.parameters += change;
  const Rigid3 motion = aligning_motion(corners, changed);
  const ProjectionUncertainty uncertainty = projection_uncertainty(truth, one);
  for (const double range_m : {0.3, 1.0, kInfinitelyFar}) {
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(640, 480), Eigen::Vector2d(200, 300), Eigen::Vector2d(900, 700)}) {
      const Eigen::Vector3d ray = *ray_from_pixel(truth.camera, pixel);
      const Eigen::Vector2d moved = *aligned_projection(changed, motion, ray, range_m) - pixel;
      const Eigen::Matrix2d covariance = *projection_covariance(uncertainty, pixel, range_m);
      EXPECT_NEAR(largest_sigma(covariance), moved.norm(), 1e-3 * moved.norm()) << pixel.transpose() << " " << range_m;
      EXPECT_LT((covariance - moved * moved.transpose()).norm(), 2e-3 * moved.squaredNorm());
    }
  }
}

// Over noisy worlds, errors that are normalised by their covariance have a mean square of 2.
TEST(ProjectionOverSeeds, ScattersAsItSays) {
  constexpr int kSeeds = 60;
  std::map<double, double> squares;
  int count = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const SyntheticWorld world = synthetic_world(fisheye_options(seed));
    const Calibration solved = solved_from_truth(world);
    const ProjectionUncertainty uncertainty = projection_uncertainty(solved.cameras[0], solved.covariance);
    const Rigid3 motion = aligning_motion(true_corners(world, 0), solved.cameras[0].camera);
    count += 2;
    for (const double range_m : {0.3, 1.0, kInfinitelyFar}) {
      for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(500, 400), Eigen::Vector2d(900, 700)}) {
        const Eigen::Vector3d ray = *ray_from_pixel(world.cameras[0], pixel);
        const Eigen::Vector2d error = *aligned_projection(solved.cameras[0].camera, motion, ray, range_m) - pixel;
        const Eigen::Matrix2d covariance = *projection_covariance(uncertainty, pixel, range_m);
        squares[range_m] += error.dot(covariance.inverse() * error);
      }
    }
  }
  // A chi-square of 2 has variance 4; two pixels of a seed are correlated, so count seeds. Four standard deviations.
  for (const auto& [range_m, sum] : squares) EXPECT_NEAR(sum / count, 2.0, 4 * 2.0 / std::sqrt(kSeeds)) << range_m;
}

TEST_F(Projection, InfinityIsTheLimitOfFarPoints) {
  const ProjectionUncertainty uncertainty = projection_uncertainty(camera(), solved_.covariance);
  const Eigen::Vector2d pixel(300, 200);
  const double far = largest_sigma(*projection_covariance(uncertainty, pixel, 1e6));
  EXPECT_NEAR(largest_sigma(*projection_covariance(uncertainty, pixel, kInfinitelyFar)), far, 1e-5 * far);
}

TEST_F(Projection, WhatIsHeldFixedIsCertain) {
  const Covariance nothing{{}, Eigen::MatrixXd(0, 0)};
  const ProjectionUncertainty uncertainty = projection_uncertainty(camera(), nothing);
  EXPECT_EQ(largest_sigma(*projection_covariance(uncertainty, {500, 400}, 1.0)), 0.0);
}

TEST_F(Projection, MapIsNanWhereThereIsNoRay) {
  RigCamera narrow = camera();
  narrow.camera.size = {4000, 4000};  // corners of the image beyond the fisheye's circle
  const UncertaintyMap map = uncertainty_map(projection_uncertainty(narrow, solved_.covariance), 1.0, 20);
  EXPECT_EQ(map.sigma_px.rows(), 20);
  EXPECT_TRUE(std::isnan(map.sigma_px(19, 19)));
  EXPECT_GT(map.sigma_px(3, 3), 0.0);
  EXPECT_EQ(map.pixel(0, 0), Eigen::Vector2d(99.5, 99.5));
}

TEST_F(Projection, CannotBeToldWithoutEvidence) {
  RigCamera old = camera();
  old.evidence.reset();
  EXPECT_THROW(projection_uncertainty(old, solved_.covariance), Error);
}

TEST_F(Projection, EvidenceCountsEveryCornerInItsCell) {
  const CornerEvidence& evidence = *camera().evidence;
  EXPECT_EQ(evidence.columns, 16);
  EXPECT_EQ(evidence.rows, 12);
  int corners = 0, counted = 0;
  for (const TargetView& view : world_.problem.views) corners += static_cast<int>(view.observations.size());
  for (const int count : evidence.corners) counted += count;
  EXPECT_EQ(counted, corners);
  const Observation& first = world_.problem.views[0].observations[0];
  EXPECT_TRUE(evidence.covers({1280, 960}, first.pixel));
  EXPECT_FALSE(evidence.covers({1280, 960}, {-0.6, 10.0}));
  EXPECT_FALSE(evidence.covers({1280, 960}, {std::nan(""), 10.0}));
}

}  // namespace
}  // namespace raybundle::testing
