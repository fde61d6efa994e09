// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/next_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "synthetic_world.hpp"

namespace raybundle {
namespace {

using testing::synthetic_world;
using testing::SyntheticOptions;
using testing::SyntheticWorld;

constexpr double kNoise_px = 0.1;

// Boards in the middle of the field only, so that a view elsewhere tells much.
SyntheticOptions narrow() {
  SyntheticOptions options;
  options.frames = 14;
  options.noise_px = kNoise_px;
  options.max_off_axis_rad = 0.7;
  return options;
}

// The problem with one more frame, in which the true cameras saw the board in a new place.
CalibrationProblem with_board(const SyntheticWorld& world, const Rigid3& rig_from_target) {
  CalibrationProblem problem = world.problem;
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, kNoise_px);
  problem.frames.push_back("another");
  TargetView view{.camera = 0, .frame = static_cast<int>(problem.frames.size()) - 1, .target = 0, .observations = {}};
  const Camera& camera = world.cameras[0];
  for (const TargetPoint& point : problem.targets[0].points) {
    const auto pixel = pixel_from_ray(camera, rig_from_target * point.x_in_target);
    if (!pixel || pixel->minCoeff() < 0) continue;
    if (pixel->x() > camera.size.width - 1 || pixel->y() > camera.size.height - 1) continue;
    const Eigen::Vector2d error(noise(random), noise(random));
    view.observations.push_back({*pixel + error, problem.views[0].observations[0].sigma_px, point.id});
  }
  problem.views.push_back(view);
  return problem;
}

// Beyond, the estimate of a world of narrow() is so wrong that no first order holds, and pixels there have other rays.
constexpr double kField_deg = 140.0;

Requirement field_requirement() {
  return requirement_from_text("projection 0.01 px over " + std::to_string(kField_deg) + " deg");
}

struct Sigmas {
  double largest = 0.0;
  double rms = 0.0;
};

// Of projections at infinity within the field, for corners of exactly the stated sigmas: two solves of different data
// scale by slightly different variance factors otherwise.
Sigmas sigmas_in_field(const CalibrationResult& result) {
  const RigCamera& camera = result.calibration.cameras[0];
  const UncertaintyMap map =
      uncertainty_map(projection_uncertainty(camera, result.calibration.covariance), kInfinitelyFar, 12);
  Sigmas sigmas;
  int count = 0;
  for (Eigen::Index row = 0; row < map.sigma_px.rows(); ++row) {
    for (Eigen::Index column = 0; column < map.sigma_px.cols(); ++column) {
      const auto ray = ray_from_pixel(camera.camera, map.pixel(row, column));
      if (!ray || std::acos(ray->z()) > kField_deg / 2 * M_PI / 180) continue;
      const double sigma = map.sigma_px(row, column) / std::sqrt(result.variance_factor);
      sigmas.largest = std::max(sigmas.largest, sigma);
      sigmas.rms += sigma * sigma;
      ++count;
    }
  }
  sigmas.rms = std::sqrt(sigmas.rms / count);
  return sigmas;
}

// What was predicted is what a solve with the view finds, up to the step of the estimate (first order) and the implied
// motion, which the prediction keeps: 15 %.
TEST(NextView, PredictsWhatTheViewWillDo) {
  const SyntheticWorld world = synthetic_world(narrow());
  const CalibrationResult before = calibrate(world.problem);
  const NextViews next = next_best_views(world.problem, before, field_requirement(), 1);
  ASSERT_EQ(next.views.size(), 1u);
  const NextView& view = next.views[0];
  const double scale = std::sqrt(before.variance_factor);
  EXPECT_NEAR(view.before / scale, sigmas_in_field(before).largest, 1e-9);
  const CalibrationResult after = calibrate(with_board(world, view.rig_from_target));
  ASSERT_GE(after.views.back().pose, 0) << "the new view was set aside";
  const double real = sigmas_in_field(after).largest;
  EXPECT_NEAR(view.after / scale, real, 0.15 * real);
  EXPECT_LT(view.after, 0.8 * view.before) << "the world does not leave room for a better view";
}

// Solved again, the suggested view does better than three of four boards in random places.
TEST(NextView, BeatsRandomViews) {
  const SyntheticWorld world = synthetic_world(narrow());
  const CalibrationResult before = calibrate(world.problem);
  const NextViews next = next_best_views(world.problem, before, field_requirement(), 1);
  ASSERT_EQ(next.views.size(), 1u);
  const double with_best = sigmas_in_field(calibrate(with_board(world, next.views[0].rig_from_target))).rms;

  SyntheticOptions anywhere = narrow();
  anywhere.seed = 5;
  anywhere.frames = 20;
  anywhere.max_off_axis_rad = 0.9;
  std::vector<double> with_random;
  for (const BoardPose& pose : synthetic_world(anywhere).poses) {
    with_random.push_back(sigmas_in_field(calibrate(with_board(world, pose.rig_from_target))).rms);
  }
  EXPECT_LE(with_best, quantile(with_random, 0.25));
}

// Each view counts on those before it, and says how the board is to be held.
TEST(NextView, ListsViewsOneAfterAnother) {
  const SyntheticWorld world = synthetic_world(narrow());
  const CalibrationResult result = calibrate(world.problem);
  const NextViews next = next_best_views(world.problem, result, field_requirement(), 3);
  ASSERT_EQ(next.views.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(next.views[i].after, next.views[i].before);
    EXPECT_DOUBLE_EQ(next.views[i].before, i > 0 ? next.views[i - 1].after : next.views[i].before);
    EXPECT_NE(next.views[i].text.find("camera0"), std::string::npos);
  }
}

}  // namespace
}  // namespace raybundle
