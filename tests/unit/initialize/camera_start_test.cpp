// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/camera_start.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "draw.hpp"
#include "raybundle/geometry/error.hpp"
#include "synthetic_world.hpp"

namespace raybundle {
namespace {

using testing::Draw;
using ::testing::HasSubstr;
using testing::synthetic_world;
using testing::SyntheticCamera;
using testing::SyntheticOptions;
using testing::SyntheticWorld;

/// Any lens of a model: 40° to as wide as its example goes, the principal point up to 10 % of the width off, pixels up
/// to 5 % from square, 5 to 60 views near and far, noise up to half a pixel, up to 20 % wrong corners.
SyntheticOptions random_options(std::string_view model, unsigned seed) {
  Draw draw(seed);
  SyntheticOptions options;
  SyntheticCamera& camera = options.cameras[0];
  camera.model = model;
  camera.size = draw.chance(0.5) ? ImageSize{1280, 960} : ImageSize{640, 480};
  double half_angle = 0.0;
  with_model(*model_named(model), [&]<CameraModel M>() {
    const auto& example = M::kExamples[static_cast<std::size_t>(draw.uniform(0, M::kExamples.size() - 1e-9))];
    camera.shape.assign(example.shape.begin(), example.shape.end());
    const double limit = std::min({M::kExamples[0].half_angle_rad, example.half_angle_rad, 1.9});
    half_angle = draw.uniform(0.35, 0.98 * limit);
    const double ray[3] = {std::sin(half_angle), 0, std::cos(half_angle)};
    double plane[2];
    ASSERT_TRUE(M::plane_from_ray(camera.shape.data(), ray, plane));
    const double circle = half_angle > 1.0 ? draw.uniform(0.7, 1.0) : 1.0;  // the image circle may end inside the image
    camera.focal_px = circle * 0.5 * camera.size.width / plane[0];
  });
  camera.aspect = draw.chance(0.5) ? 1.0 : draw.uniform(0.95, 1.05);
  const double off = (draw.chance(0.5) ? 0.01 : 0.1) * camera.size.width;
  camera.centre_offset_px = {draw.uniform(-off, off), draw.uniform(-off, off)};
  options.frames = static_cast<int>(draw.uniform(5, 61));
  options.noise_px = draw.uniform(0, 0.5);
  options.outlier_fraction = draw.chance(0.5) ? 0.0 : draw.uniform(0, 0.2);
  const double filling = 0.19 / std::tan(std::min(half_angle, 1.2));  // distance at which the board fills the image
  options.min_distance_m = std::max(0.2, filling * draw.uniform(0.6, 1.5));
  options.max_distance_m = options.min_distance_m * draw.uniform(1.2, 3.0);
  options.max_off_axis_rad = half_angle * draw.uniform(0.5, 0.9);
  options.max_tilt_rad = draw.uniform(0.5, 1.0);
  options.seed = seed;
  return options;
}

/// Distances [px] of the right corners of posed views from where the start puts them.
std::vector<double> errors_px(const SyntheticWorld& world, const CameraStart& start) {
  std::vector<double> errors;
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    const TargetView& view = world.problem.views[v];
    if (!start.camera_from_target[v]) continue;
    for (std::size_t i = 0; i < view.observations.size(); ++i) {
      if (world.outliers[v][i]) continue;
      const TargetPoint* point = world.problem.targets[view.target].find(view.observations[i].point_id);
      const auto pixel = pixel_from_ray(start.camera, *start.camera_from_target[v] * point->x_in_target);
      errors.push_back(pixel ? (*pixel - view.observations[i].pixel).norm() : INFINITY);
    }
  }
  std::ranges::sort(errors);
  return errors;
}

int posed(const CameraStart& start) {
  return static_cast<int>(std::ranges::count_if(start.camera_from_target, [](const auto& p) { return p.has_value(); }));
}

TEST(CameraStart, FindsAnyLensOfAnyModelFromViewsAlone) {
  for (const std::string_view model : model_names()) {
    for (unsigned seed = 0; seed < 6; ++seed) {
      const SyntheticOptions options = random_options(model, seed);
      const SyntheticWorld world = synthetic_world(options);
      SCOPED_TRACE(std::string(model) + ", seed " + std::to_string(seed));
      const CameraStart start = initialize_camera(world.problem, 0);
      const std::vector<double> errors = errors_px(world, start);
      ASSERT_FALSE(errors.empty());
      // Noise of two coordinates, three sigmas at the 98th percentile, and 0.4 px: far inside the basin
      // of the bundle, whose corners attract over tens of pixels.
      EXPECT_LT(errors[errors.size() * 98 / 100], 3.0 * options.noise_px + 0.4);
      EXPECT_GE(posed(start), static_cast<int>(0.9 * static_cast<double>(world.problem.views.size())));
    }
  }
}

TEST(CameraStart, SameInputSameBits) {
  const SyntheticWorld world = synthetic_world(random_options("kannala_brandt", 3));
  const CameraStart a = initialize_camera(world.problem, 0);
  const CameraStart b = initialize_camera(world.problem, 0);
  EXPECT_EQ(a.camera.parameters, b.camera.parameters);
}

TEST(CameraStart, WholeWrongViewsAreNamedWithNumbersAndCostNothing) {
  SyntheticOptions options = random_options("kannala_brandt", 1);
  options.frames = 24;
  options.outlier_fraction = 0.0;
  options.min_points = 40;
  SyntheticWorld world = synthetic_world(options);
  ASSERT_GE(world.problem.views.size(), 12u);
  Draw draw(5);
  for (const std::size_t v : {1u, 4u, 7u}) {  // corners that have nothing to do with the board
    for (Observation& observation : world.problem.views[v].observations) {
      observation.pixel << draw.uniform(0, options.cameras[0].size.width),
          draw.uniform(0, options.cameras[0].size.height);
    }
    world.outliers[v].assign(world.outliers[v].size(), true);
  }
  const CameraStart start = initialize_camera(world.problem, 0);
  for (const std::size_t v : {1u, 4u, 7u}) {
    EXPECT_FALSE(start.camera_from_target[v]);
    EXPECT_THAT(start.reasons[v], HasSubstr("corners fit within 3.0 px"));
  }
  EXPECT_EQ(posed(start), static_cast<int>(world.problem.views.size()) - 3);
  const std::vector<double> errors = errors_px(world, start);
  EXPECT_LT(errors[errors.size() * 98 / 100], 3.0 * options.noise_px + 0.25);
}

TEST(CameraStart, AModelThatCannotDescribeTheLensGetsItsBestFit) {
  SyntheticOptions options;
  options.frames = 25;
  options.noise_px = 0.2;
  SyntheticWorld world = synthetic_world(options);  // kannala_brandt, corners to 97° off the axis
  for (const std::string_view model : model_names()) {
    SCOPED_TRACE(model);
    world.problem.cameras[0].model = *model_named(model);
    const CameraStart start = initialize_camera(world.problem, 0);
    EXPECT_TRUE(start.camera.parameters.allFinite());
    EXPECT_GE(posed(start), 3);
  }
}

TEST(CameraStart, GivenParametersAreKeptAndPosesFound) {
  SyntheticOptions options;
  options.frames = 6;
  SyntheticWorld world = synthetic_world(options);
  world.problem.cameras[0].parameters = world.cameras[0].parameters;
  const CameraStart start = initialize_camera(world.problem, 0);
  EXPECT_EQ(start.camera.parameters, world.cameras[0].parameters);
  EXPECT_LT(errors_px(world, start).back(), 1e-4);  // exact observations; refined until steps stop paying
}

std::string failure_of(const CalibrationProblem& problem) {
  try {
    initialize_camera(problem, 0);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNotEnoughData);
    return error.what();
  }
  return "no error";
}

TEST(CameraStart, TooFewViewsAreAnErrorThatCountsThem) {
  SyntheticOptions options;
  options.frames = 2;
  EXPECT_THAT(failure_of(synthetic_world(options).problem), HasSubstr("there are only 2 views of the board"));
}

TEST(CameraStart, BoardsParallelToTheImageAreAnErrorForNarrowLenses) {
  SyntheticOptions options;
  options.cameras[0].model = "pinhole";
  options.cameras[0].focal_px = 1200;
  options.noise_px = 0.2;
  options.frames = 12;
  SyntheticWorld world = synthetic_world(options);
  Draw draw(3);
  std::size_t kept = 0;
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    Rigid3 pose;  // parallel to the image, anywhere in it
    pose.translation << draw.uniform(-0.3, 0.1), draw.uniform(-0.25, 0.05), draw.uniform(0.6, 1.2);
    TargetView view = world.problem.views[v];
    view.observations.clear();
    for (const TargetPoint& point : world.problem.targets[0].points) {
      const auto pixel = pixel_from_ray(world.cameras[0], pose * point.x_in_target);
      const Eigen::Vector2d noise(draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3));
      if (pixel) view.observations.push_back({*pixel + noise, 0.2, point.id});
    }
    world.problem.views[kept++] = view;
  }
  world.problem.views.resize(kept);
  EXPECT_THAT(failure_of(world.problem), HasSubstr("tilt the board"));
}

TEST(InitializeView, FindsThePoseOfOneViewOrSaysWhyNot) {
  SyntheticOptions options;
  options.noise_px = 0.2;
  options.outlier_fraction = 0.2;
  const SyntheticWorld world = synthetic_world(options);
  std::string reason;
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    const auto pose = initialize_view(world.problem, world.problem.views[v], world.cameras[0], reason);
    ASSERT_TRUE(pose) << reason;
    EXPECT_TRUE(reason.empty());
    const Rigid3& truth = world.poses[world.pose_of_view[v]].rig_from_target;
    EXPECT_LT(angle_between(*pose, truth), 0.05);
  }
  TargetView view = world.problem.views[0];
  view.observations.resize(3);
  EXPECT_FALSE(initialize_view(world.problem, view, world.cameras[0], reason));
  EXPECT_THAT(reason, HasSubstr("only 3 corners"));
}

}  // namespace
}  // namespace raybundle
