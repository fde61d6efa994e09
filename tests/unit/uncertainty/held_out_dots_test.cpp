// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/held_out_dots.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "synthetic_world.hpp"

namespace raybundle::testing {
namespace {

/// A fisheye and nine beams from beside it, which make dots amid a board.
struct Scene {
  Calibration calibration;
  CalibrationProblem problem;
  Rigid3 rig_from_target;

  std::vector<HeldOutDot> explained(double tolerance_px = 2.0) const {
    return explain_dots(calibration, problem, {rig_from_target}, tolerance_px);
  }
  TargetView& view() { return problem.views[0]; }
  std::vector<LaserBeam>& beams() { return calibration.laser->beams; }
};

Eigen::Vector3d dot_in_target(int beam) { return {0.05 + 0.1 * (beam % 3), 0.04 + 0.08 * (beam / 3), 0.0}; }

// The board stands so far off the axis, 0.8 m away and a little oblique; its z points away from the camera.
Scene scene_at(double off_axis_rad) {
  const Camera camera = start_camera(*model_named("kannala_brandt"), {1600, 960}, 380.0);
  const Target board = grid_target("board", 6, 5, 0.06);
  const Eigen::Vector3d centre_in_target(0.15, 0.12, 0.0), projector(0.05, 0.03, 0.0);
  Scene scene;
  scene.rig_from_target.rotation = Eigen::AngleAxisd(off_axis_rad, Eigen::Vector3d::UnitY()) *
                                   Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  const Eigen::Vector3d ray(std::sin(off_axis_rad), 0.0, std::cos(off_axis_rad));
  scene.rig_from_target.translation = 0.8 * ray - scene.rig_from_target.rotation * centre_in_target;
  scene.calibration.cameras = {{"one", camera, {}}};
  scene.calibration.targets = {{board, {}}};
  scene.calibration.laser = LaserPattern{.grid = {3, 3}, .beams = {}, .grating = {}};
  scene.problem.cameras = {{"one", camera.model, camera.size, {}, {}}};
  scene.problem.targets = {board};
  scene.problem.frames = {"0"};
  scene.problem.views = {{.camera = 0, .frame = 0, .target = 0, .observations = {}}};
  for (int beam = 0; beam < 9; ++beam) {
    const Eigen::Vector3d x_in_rig = scene.rig_from_target * dot_in_target(beam);
    scene.beams().push_back({beam / 3, beam % 3, {projector, (x_in_rig - projector).normalized()}});
    scene.view().dots.push_back({.pixel = *pixel_from_ray(camera, x_in_rig)});
  }
  return scene;
}

// The same board with the other face to the camera.
Rigid3 flipped(const Rigid3& rig_from_target) {
  return rig_from_target * Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX())), {}};
}

constexpr double kOffAxis_rad[] = {0.2, 1.75};  // before the camera, and behind its shoulder

TEST(HeldOutDots, ExactOnesLieOnTheBoardWhereTheirBeamsMeetIt) {
  for (const double off_axis_rad : kOffAxis_rad) {
    const Scene scene = scene_at(off_axis_rad);
    const std::vector<HeldOutDot> explained = scene.explained();
    ASSERT_EQ(explained.size(), 9U);
    for (int i = 0; i < 9; ++i) {
      EXPECT_EQ(explained[i].dot, i);
      EXPECT_EQ(explained[i].beam, i);
      EXPECT_LT(explained[i].residual_px.norm(), 1e-9);
      EXPECT_LT(std::abs(explained[i].off_board_m), 1e-9);
      EXPECT_NEAR(explained[i].depth_m, (scene.rig_from_target * dot_in_target(i)).z(), 1e-9);
    }
  }
}

// Dots of a board that has come 5 mm nearer than it is known to be, or gone as much farther.
TEST(HeldOutDots, TellOnWhichSideOfTheBoardTheyLie) {
  for (const double off_axis_rad : kOffAxis_rad) {
    for (const double nearer_m : {5e-3, -5e-3}) {
      Scene scene = scene_at(off_axis_rad);
      scene.rig_from_target.translation += nearer_m * (scene.rig_from_target.rotation * Eigen::Vector3d::UnitZ());
      for (const Rigid3& known : {scene.rig_from_target, flipped(scene.rig_from_target)}) {
        scene.rig_from_target = known;
        const std::vector<HeldOutDot> explained = scene.explained();
        EXPECT_EQ(explained.size(), 9U);
        for (const HeldOutDot& dot : explained) {
          EXPECT_NEAR(dot.off_board_m, nearer_m, 1e-9) << off_axis_rad;
          EXPECT_GT(dot.residual_px.norm(), 0.01);
        }
      }
    }
  }
}

TEST(HeldOutDots, AreUnexplainedBetweenTwoBeamsAndFarFromAll) {
  Scene scene = scene_at(0.2);
  std::vector<Dot>& dots = scene.view().dots;
  const Eigen::Vector2d first = dots[0].pixel, second = dots[1].pixel;
  dots.resize(2);
  dots[0].pixel = 0.5 * (first + second);  // some 24 px from both
  dots[1].pixel = second + Eigen::Vector2d(3.0, 0.0);
  EXPECT_TRUE(scene.explained(2.0).empty());
  const std::vector<HeldOutDot> explained = scene.explained(100.0);
  ASSERT_EQ(explained.size(), 1U);
  EXPECT_EQ(explained[0].dot, 1);
  EXPECT_EQ(explained[0].beam, 1);
}

TEST(DotsOnBoard, CountsWhatMeetsTheBoardAmidItsPoints) {
  Scene scene = scene_at(0.2);
  const auto counted = [&](const std::optional<Rigid3>& rig_from_target) {
    return dots_on_boards(scene.calibration, scene.problem, {rig_from_target}).at(0);
  };
  scene.view().dots.push_back({.pixel = {10.0, 10.0}});
  EXPECT_EQ(counted(scene.rig_from_target).dots, 9);
  EXPECT_EQ(counted(scene.rig_from_target).beams, 9);
  scene.beams()[4].line.direction = Eigen::Vector3d(-1.0, 0.0, 0.1).normalized();
  EXPECT_EQ(counted(scene.rig_from_target).beams, 8);
  EXPECT_EQ(counted(scene.rig_from_target).to_explain(), 8);
  EXPECT_EQ(counted(std::nullopt).to_explain(), 0);
}

TEST(PointOnBeam, IsWhereThePixelIsOrNowhere) {
  Scene scene = scene_at(0.2);
  const RigCamera& camera = scene.calibration.cameras[0];
  const Line3& line = scene.beams()[5].line;
  const auto found = point_on_beam(camera, line, *pixel_from_ray(camera.camera, line.at(0.7)), 0.9);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - line.at(0.7)).norm(), 1e-9);
  const Line3 along_the_ray{Eigen::Vector3d::Zero(), Eigen::Vector3d(0.1, 0.2, 1.0).normalized()};
  EXPECT_FALSE(point_on_beam(camera, along_the_ray, *pixel_from_ray(camera.camera, along_the_ray.at(1.0)), 1.0));
}

}  // namespace
}  // namespace raybundle::testing
