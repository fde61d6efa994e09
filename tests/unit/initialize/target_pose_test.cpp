// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/target_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "draw.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

using testing::Draw;

/// A board or a point cloud in a random place around the camera, seen exactly or not.
struct Scene {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> rays;
  Rigid3 truth;
};

/// Points of spread ~0.1 m at 0.3 to 2 m, anywhere on the sphere.
Scene random_scene(unsigned seed, int count, bool planar, double noise_rad) {
  Draw draw(seed);
  Scene scene;
  scene.truth.rotation = rotation_from_vector(draw.uniform(0, M_PI) * draw.direction());
  scene.truth.translation = draw.uniform(0.3, 2.0) * draw.direction();
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d point(draw.uniform(-0.15, 0.15), draw.uniform(-0.1, 0.1),
                                planar ? 0.0 : draw.uniform(-0.1, 0.1));
    scene.points.push_back(point);
    scene.rays.push_back(((scene.truth * point).normalized() + noise_rad * draw.direction()).normalized());
  }
  return scene;
}

TEST(TargetPose, RecoversPlanarAndSpatialTargetsAnywhereOnTheSphere) {
  for (unsigned seed = 0; seed < 400; ++seed) {
    const bool planar = seed % 2 == 0;
    const Scene scene = random_scene(seed, 4 + static_cast<int>(seed % 30), planar, 0.0);
    const std::vector<TargetPose> poses = target_pose(scene.points, scene.rays);
    ASSERT_FALSE(poses.empty()) << seed;
    // Exact rays: what is left is rounding, magnified by how little four points in a near line may fix the pose.
    EXPECT_LT(poses[0].rms_rad, 1e-9) << seed;
    if (scene.points.size() < 6) continue;  // fewer points may have a second exact pose
    EXPECT_LT(angle_between(poses[0].camera_from_target, scene.truth), 1e-6) << seed;
    EXPECT_LT((poses[0].camera_from_target.translation - scene.truth.translation).norm(), 1e-6) << seed;
  }
}

TEST(TargetPose, OneOfTheTwoCandidatesIsTrueForSmallFarBoards) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    Draw draw(seed);
    Scene scene;
    const Eigen::Vector3d sight = draw.direction();
    const Eigen::Quaterniond towards = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), sight);
    scene.truth.rotation = towards * Eigen::Quaterniond(rotation_from_vector(Eigen::Vector3d(0.6, 0.2, 1.0)));
    scene.truth.translation = 3.0 * sight;
    for (int i = 0; i < 54; ++i) {
      const Eigen::Vector3d point(0.025 * (i % 9 - 4), 0.025 * (i / 9 - 2.5), 0);
      scene.points.push_back(point);
      scene.rays.push_back(((scene.truth * point).normalized() + 3e-4 * draw.direction()).normalized());
    }
    const std::vector<TargetPose> poses = target_pose(scene.points, scene.rays);
    ASSERT_FALSE(poses.empty());
    double nearest = M_PI;
    for (const TargetPose& pose : poses) {
      nearest = std::min(nearest, angle_between(pose.camera_from_target, scene.truth));
    }
    EXPECT_LT(nearest, 0.35) << seed;  // noise of a tenth of a square leaves about 0.1 rad of tilt
  }
}

TEST(TargetPose, CollinearOrTooFewPointsHaveNoPose) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> rays;
  for (int i = 0; i < 6; ++i) {
    points.emplace_back(0.1 * i, 0.05 * i, 0);
    rays.push_back((points.back() + Eigen::Vector3d(0, 0, 1)).normalized());
  }
  EXPECT_TRUE(target_pose(points, rays).empty());
  points.resize(3);
  rays.resize(3);
  EXPECT_TRUE(target_pose(points, rays).empty());
  rays.resize(2);
  EXPECT_THROW(target_pose(points, rays), Error);
}

TEST(RobustTargetPose, SurvivesFortyPercentWrongPairsAndIsRepeatable) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const bool planar = seed % 2 == 0;
    Scene scene = random_scene(seed, 40, planar, 1e-3);
    Draw draw(seed + 1000);
    for (int i = 0; i < 16; ++i) {
      scene.rays[i] = (scene.rays[i] + draw.uniform(0.05, 0.5) * draw.direction()).normalized();
    }
    const auto pose = robust_target_pose(scene.points, scene.rays, 4e-3, seed);
    ASSERT_TRUE(pose.has_value()) << seed;
    double squares = 0.0;
    for (std::size_t i = 16; i < scene.points.size(); ++i) {
      squares += ((pose->camera_from_target * scene.points[i]).normalized() - scene.rays[i]).squaredNorm();
    }
    EXPECT_LT(std::sqrt(squares / 24), 1.5e-3) << seed;  // noise is 1e-3; a wrong pose would be off by 1e-2 and more
    const auto again = robust_target_pose(scene.points, scene.rays, 4e-3, seed);
    EXPECT_EQ(again->camera_from_target.translation, pose->camera_from_target.translation);
  }
}

}  // namespace
}  // namespace raybundle
