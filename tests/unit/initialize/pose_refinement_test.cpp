// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../calib_core/initialize/src/pose_refinement.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {
namespace {

using Eigen::Vector3d;

const Rigid3 kPose{Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vector3d(1, 2, -1).normalized())),
                   Vector3d(0.1, -0.05, 0.6)};

/// A board's points and the rays to them, wide of the axis.
struct Seen {
  std::vector<Vector3d> points, rays;
};

Seen seen_points(int count) {
  Seen seen;
  for (int i = 0; i < count; ++i) {
    seen.points.emplace_back(0.1 * (i % 4), 0.12 * (i / 4), 0.0);  // NOLINT(bugprone-integer-division): rows
    seen.rays.push_back((kPose * seen.points.back()).normalized());
  }
  return seen;
}

Rigid3 beside(const Rigid3& pose) {
  return perturbed(pose, (Eigen::Matrix<double, 6, 1>() << 0.05, -0.03, 0.04, 0.02, 0.01, -0.03).finished());
}

double off(const Rigid3& a, const Rigid3& b) {
  return a.rotation.angularDistance(b.rotation) + (a.translation - b.translation).norm();
}

// Pairs are taken four at once and those that are left one by one: no count may make a difference.
TEST(PoseRefinement, FindsThePoseOfAnyCountOfPairs) {
  for (int count = 6; count <= 13; ++count) {
    const Seen seen = seen_points(count);
    Rigid3 pose = beside(kPose);
    refine_on_rays(seen.points, seen.rays, pose, 50, 0.0, 0.0);
    EXPECT_LT(off(pose, kPose), 1e-7) << count;  // the root of rounding: the cost is a square
  }
}

TEST(PoseRefinement, AWrongPairHardlyPulls) {
  Seen seen = seen_points(16);
  seen.rays[5] = Vector3d(1, 1, 0.2).normalized();
  Rigid3 pose = beside(kPose);
  refine_on_rays(seen.points, seen.rays, pose, 50, 1e-3, 0.0);
  EXPECT_LT(off(pose, kPose), 1e-4);
}

TEST(PoseRefinement, APointInTheCentreOfProjectionCostsOnlyItself) {
  Seen seen = seen_points(12);
  seen.points.push_back(kPose.inverse() * Vector3d::Zero());
  seen.rays.push_back(Vector3d::UnitZ());
  Rigid3 pose = kPose;
  const double cost = refine_on_rays(seen.points, seen.rays, pose, 20, 0.01, 0.0);
  EXPECT_NEAR(cost, 1e-4, 1e-6);  // of the pair that has no direction: the scale's square
  EXPECT_LT(off(pose, kPose), 1e-4);
}

}  // namespace
}  // namespace raybundle
