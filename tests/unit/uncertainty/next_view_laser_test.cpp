// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "laser_world.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/scene/board_surface.hpp"
#include "raybundle/uncertainty/next_view.hpp"
#include "raybundle/uncertainty/verdict.hpp"

namespace raybundle {
namespace {

constexpr double kNoise_px = 0.1;

struct LaserWorld {
  testing::SyntheticWorld world;
  testing::LaserTruth laser;
};

LaserWorld laser_world() {
  testing::SyntheticOptions options = testing::laser_rig_options(14, 3);
  options.noise_px = kNoise_px;
  LaserWorld made{testing::synthetic_world(options), {}};
  made.laser =
      testing::add_laser(made.world, {.grid = {.rows = 7, .columns = 7}, .noise_px = kNoise_px, .labelled = true});
  return made;
}

// The problem with one more frame, in which the true camera saw the board, and the beams on it, in a new place.
CalibrationProblem with_board(const LaserWorld& made, const Rigid3& rig_from_target) {
  CalibrationProblem problem = made.world.problem;
  const Camera& camera = made.world.cameras[0];
  const Target& target = problem.targets[0];
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, kNoise_px);
  const auto seen = [&](const Eigen::Vector3d& x_in_target) -> std::optional<Eigen::Vector2d> {
    const auto pixel = pixel_from_ray(camera, rig_from_target * x_in_target);
    if (!pixel || pixel->minCoeff() < 0 || pixel->x() > camera.size.width - 1) return std::nullopt;
    if (pixel->y() > camera.size.height - 1) return std::nullopt;
    const double u = noise(random), v = noise(random);
    return *pixel + Eigen::Vector2d(u, v);
  };
  problem.frames.push_back("another");
  TargetView view{.camera = 0, .frame = static_cast<int>(problem.frames.size()) - 1, .target = 0, .observations = {}};
  for (const TargetPoint& point : target.points) {
    const auto pixel = seen(point.x_in_target);
    if (pixel) view.observations.push_back({*pixel, problem.views[0].observations[0].sigma_px, point.id});
  }
  const BoardSurface surface(target);
  for (std::size_t b = 0; b < made.laser.lines.size(); ++b) {
    if (!made.laser.lines[b]) continue;
    const auto x = surface.crossing(rig_from_target.inverse() * *made.laser.lines[b], {});
    if (!x || !surface.covers(*x)) continue;
    const auto pixel = seen(*x);
    if (pixel) view.dots.push_back({*pixel, problem.views[0].dots[0].covariance_px2, static_cast<int>(b)});
  }
  problem.views.push_back(view);
  return problem;
}

double depth_sigma(const CalibrationProblem& problem, const CalibrationResult& result, const Requirement& requirement) {
  return verdict(problem, result, {requirement}).judgements[0].value;
}

// Where a laser's depth is required, the next best view reduces it, by about what is predicted. Noise decides the rest:
// the beams of another solve are others, and so is their spread.
TEST(NextViewForALaser, ReducesTheDepthAsPredicted) {
  const LaserWorld made = laser_world();
  const CalibrationResult before = calibrate(made.world.problem);
  ASSERT_TRUE(before.calibration.laser);
  const Requirement requirement = requirement_from_text("depth 1 mm at 1 m");
  const NextViews next = next_best_views(made.world.problem, before, requirement, 1);
  ASSERT_EQ(next.views.size(), 1u);
  const NextView& view = next.views[0];
  EXPECT_NE(next.objective.find("dots"), std::string::npos);
  EXPECT_NEAR(view.before, depth_sigma(made.world.problem, before, requirement), 1e-9);
  EXPECT_LT(view.after, 0.95 * view.before);
  const CalibrationProblem more = with_board(made, view.rig_from_target);
  ASSERT_GT(more.views.back().dots.size(), 5u);
  const double real = depth_sigma(more, calibrate(more), requirement);
  EXPECT_LT(real, view.before);
  EXPECT_NEAR(view.after, real, 0.3 * real);
}

}  // namespace
}  // namespace raybundle
