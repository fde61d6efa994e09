// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/rig_start.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "draw.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/initialize/tie_check.hpp"
#include "synthetic_world.hpp"

namespace raybundle {
namespace {

using testing::Draw;
using ::testing::HasSubstr;
using testing::synthetic_world;
using testing::SyntheticCamera;
using testing::SyntheticOptions;
using testing::SyntheticWorld;
using Poses = std::vector<std::optional<Rigid3>>;

Rigid3 rig_place(double yaw_rad, double x_m) {
  return {Eigen::Quaterniond(rotation_from_vector(Eigen::Vector3d(0, yaw_rad, 0))), Eigen::Vector3d(x_m, 0.01, 0)};
}

/// Cameras side by side, each turned away from the one before, so that far ones share no board.
SyntheticWorld fan(int cameras, double turn_rad, int frames, unsigned seed) {
  SyntheticOptions options;
  options.cameras.clear();
  for (int c = 0; c < cameras; ++c) {
    SyntheticCamera camera;
    if (c > 0) camera.camera_from_rig = rig_place(-turn_rad * c, -0.1 * c);
    options.cameras.push_back(camera);
  }
  options.frames = frames;
  options.seed = seed;
  options.min_points = 30;
  return synthetic_world(options);
}

/// True poses with small errors, as initialize_camera would give them.
Poses noisy_poses(const SyntheticWorld& world, double noise_rad, double noise_m, unsigned seed) {
  Poses poses;
  Draw draw(seed);
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    const Rigid3 exact =
        world.camera_from_rig[world.problem.views[v].camera] * world.poses[world.pose_of_view[v]].rig_from_target;
    Eigen::Matrix<double, 6, 1> motion;
    for (double& each : motion) each = draw.uniform(-1, 1);
    motion.head<3>() *= noise_rad;
    motion.tail<3>() *= noise_m;
    poses.push_back(perturbed(exact, motion));
  }
  return poses;
}

/// Views whose board another camera shows in the same frame, but that hold it alone.
std::vector<int> untied_views(const CalibrationProblem& problem, const RigStart& start) {
  std::vector<int> untied;
  const int count = static_cast<int>(problem.views.size());
  for (int v = 0; v < count; ++v) {
    bool shared = false, tied = false;
    for (int w = 0; w < count; ++w) {
      const bool same_board =
          problem.views[v].frame == problem.views[w].frame && problem.views[v].target == problem.views[w].target;
      if (w == v || !same_board || start.pose_of_view[v] < 0 || start.pose_of_view[w] < 0) continue;
      shared = true;
      tied = tied || start.pose_of_view[v] == start.pose_of_view[w];
    }
    if (shared && !tied) untied.push_back(v);
  }
  return untied;
}

void expect_near_truth(const SyntheticWorld& world, const RigStart& start, double angle_rad, double distance_m) {
  for (std::size_t c = 0; c < world.camera_from_rig.size(); ++c) {
    EXPECT_LT(angle_between(start.camera_from_rig[c], world.camera_from_rig[c]), angle_rad) << "camera " << c;
    EXPECT_LT((start.camera_from_rig[c].translation - world.camera_from_rig[c].translation).norm(), distance_m)
        << "camera " << c;
  }
}

TEST(RigStart, ChainOfCamerasIsExactForExactPoses) {
  const SyntheticWorld world = fan(4, 0.9, 60, 3);
  const RigStart start = initialize_rig(world.problem, noisy_poses(world, 0, 0, 1));
  expect_near_truth(world, start, 1e-7, 1e-9);
  EXPECT_TRUE(untied_views(world.problem, start).empty());
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    const BoardPose& pose = start.poses[start.pose_of_view[v]];
    EXPECT_EQ(pose.frame, world.problem.views[v].frame);
    EXPECT_EQ(pose.target, world.problem.views[v].target);
    EXPECT_EQ(start.symmetry_of_view[v], -1);
  }
}

TEST(RigStart, NoisyPosesAreAveragedAndHardlyAnyIsSetAside) {
  std::size_t views = 0, untied = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const SyntheticWorld world = fan(3, 0.6, 30, seed + 1);
    const RigStart start = initialize_rig(world.problem, noisy_poses(world, 3e-3, 1e-3, seed));
    expect_near_truth(world, start, 6e-3, 4e-3);  // the noise of one pose, along a chain of two ties
    views += world.problem.views.size();
    untied += untied_views(world.problem, start).size();
  }
  EXPECT_LE(untied, views / 100);  // 0.2 % over 300 seeds: the limit is a multiple of the noise that frames show
}

TEST(RigStart, ABoardThatMovedBetweenTheCamerasKeepsItsOwnPoses) {
  const SyntheticWorld world = fan(2, 0.2, 20, 5);
  Poses poses = noisy_poses(world, 1e-3, 5e-4, 2);
  int moved_view = -1;
  int partner = -1;
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    const TargetView& view = world.problem.views[v];
    if (view.frame != 8) continue;
    (view.camera == 1 ? moved_view : partner) = static_cast<int>(v);
  }
  ASSERT_GE(moved_view, 0);
  ASSERT_GE(partner, 0);
  Eigen::Matrix<double, 6, 1> motion;
  motion << 0.03, 0.02, 0, 0.01, 0, 0.02;
  poses[moved_view] = perturbed(*poses[moved_view], motion);

  const RigStart start = initialize_rig(world.problem, poses);
  EXPECT_THAT(untied_views(world.problem, start), ::testing::UnorderedElementsAre(moved_view, partner));
  expect_near_truth(world, start, 2e-3, 2e-3);
}

// Three frames only: what two of them say must win, though the third agrees with itself.
TEST(RigStart, BoardsHeldMirroredByOneCameraAreHeldAsTheOtherSeesThem) {
  const SyntheticWorld world = fan(2, 0.1, 3, 3);
  for (const int camera : {0, 1}) {
    Poses poses = noisy_poses(world, 0, 0, 1);
    Poses mirrored(poses.size());
    for (std::size_t v = 0; v < poses.size(); ++v) {
      if (world.problem.views[v].frame != 0 || world.problem.views[v].camera != camera) continue;
      mirrored[v] = poses[v];
      poses[v]->rotation = Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX()) * poses[v]->rotation;
    }
    const RigStart start = initialize_rig(world.problem, poses, mirrored);
    EXPECT_TRUE(untied_views(world.problem, start).empty());
    expect_near_truth(world, start, 1e-9, 1e-9);
    EXPECT_FALSE(untied_views(world.problem, initialize_rig(world.problem, poses)).empty());
  }
}

TEST(RigStart, SymmetricBoardsAreRelabelledInCamerasThatTurnedThem) {
  SyntheticWorld world = fan(3, 0.3, 24, 7);
  Target& target = world.problem.targets[0];
  TargetSymmetry half_turn;
  const int last = static_cast<int>(target.points.size()) - 1;
  for (const TargetPoint& point : target.points) half_turn.ids.push_back(last - point.id);
  target.symmetries.push_back(half_turn);

  Poses poses = noisy_poses(world, 1e-3, 5e-4, 4);
  const Eigen::Vector3d end = target.points.back().x_in_target;
  const Rigid3 turned{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ())), end};
  std::vector<bool> flipped(poses.size(), false);
  for (std::size_t v = 0; v < poses.size(); ++v) {
    if (world.problem.views[v].camera == 0 || (v * 7) % 3 != 0) continue;
    poses[v] = *poses[v] * turned;  // labels run from the other end of the board
    flipped[v] = true;
  }
  const RigStart start = initialize_rig(world.problem, poses);
  expect_near_truth(world, start, 4e-3, 4e-3);
  EXPECT_TRUE(untied_views(world.problem, start).empty());
  // Views of one board share a pose and, once relabelled, one way round.
  for (std::size_t v = 0; v < poses.size(); ++v) {
    for (std::size_t w = 0; w < v; ++w) {
      if (start.pose_of_view[v] != start.pose_of_view[w]) continue;
      EXPECT_EQ(flipped[v] != flipped[w], start.symmetry_of_view[v] != start.symmetry_of_view[w]);
    }
  }
}

TEST(RigStart, SeveralBoardsMoveIndependently) {
  SyntheticOptions options;
  options.cameras.resize(2);
  options.cameras[1].camera_from_rig = rig_place(0.1, -0.12);
  options.boards = 3;
  const SyntheticWorld world = synthetic_world(options);
  const RigStart start = initialize_rig(world.problem, noisy_poses(world, 0, 0, 1));
  expect_near_truth(world, start, 1e-7, 1e-9);
}

TEST(CheckTies, AnExcessOfOneIsHonestAndASmallMotionStandsOut) {
  SyntheticOptions options;
  options.cameras.resize(2);
  options.cameras[1].camera_from_rig = rig_place(0.1, -0.12);
  options.noise_px = 0.2;
  options.min_points = 40;
  SyntheticWorld world = synthetic_world(options);
  const int moved = world.pose_of_view[0];  // seen by the second camera three millimetres further on
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    TargetView& view = world.problem.views[v];
    if (view.camera != 1 || world.pose_of_view[v] != moved) continue;
    for (Observation& observation : view.observations) {
      const Eigen::Vector3d point = world.problem.targets[0].find(observation.point_id)->x_in_target;
      const Rigid3 pose = world.camera_from_rig[1] * world.poses[moved].rig_from_target;
      const Eigen::Vector3d step(0.002, 0.002, 0);
      observation.pixel +=
          *pixel_from_ray(world.cameras[1], pose * point + step) - *pixel_from_ray(world.cameras[1], pose * point);
    }
  }
  const std::vector<TieCheck> checks =
      check_ties(world.problem, world.cameras, world.camera_from_rig, world.shapes, world.poses, world.pose_of_view);
  ASSERT_GE(checks.size(), 5u);
  for (const TieCheck& check : checks) {
    if (check.pose == moved) {
      EXPECT_GT(check.excess, 5.0);
      EXPECT_THAT(check.reason, HasSubstr("camera0 and camera1 fit to"));
    } else {
      // True poses instead of fitted ones: two poses' freedoms are lost, sqrt(2), of which chance makes up to twice.
      EXPECT_LT(check.excess, 3.0);
    }
  }
}

TEST(RigStart, CamerasWithoutACommonBoardAreNamed) {
  SyntheticWorld world = fan(2, 0.2, 10, 9);
  Poses poses = noisy_poses(world, 0, 0, 1);
  for (std::size_t v = 0; v < poses.size(); ++v) {
    if (world.problem.views[v].frame % 2 == world.problem.views[v].camera) poses[v].reset();
  }
  try {
    initialize_rig(world.problem, poses);
    FAIL() << "cameras that share no frame have no relative pose";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNotEnoughData);
    EXPECT_THAT(error.what(), HasSubstr("camera1"));
    EXPECT_THAT(error.what(), HasSubstr("camera0"));
  }
  world.problem.cameras[1].camera_from_rig = world.camera_from_rig[1];  // known beforehand, no tie is needed
  expect_near_truth(world, initialize_rig(world.problem, poses), 1e-9, 1e-9);
}

}  // namespace
}  // namespace raybundle
