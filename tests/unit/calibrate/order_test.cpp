// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "synthetic_world.hpp"

namespace raybundle {
namespace {

using testing::synthetic_world;
using testing::SyntheticOptions;

// Three cameras, 0.3 px noise, 2 % outliers.
CalibrationProblem rig_problem() {
  SyntheticOptions options;
  options.frames = 24;
  options.max_off_axis_rad = 0.7;
  options.noise_px = 0.3;
  options.outlier_fraction = 0.02;
  options.seed = 3;
  for (const double side : {0.12, -0.15}) {
    testing::SyntheticCamera camera = options.cameras[0];
    camera.focal_px = 390.0 + 50.0 * side;
    camera.camera_from_rig.rotation = Eigen::Quaterniond(rotation_from_vector({0.02, side, -0.01}));
    camera.camera_from_rig.translation = Eigen::Vector3d(-side, 0.004, 0.01);
    options.cameras.push_back(camera);
  }
  return synthetic_world(options).problem;
}

// std::shuffle differs between standard libraries.
template <typename T>
void shuffle(std::vector<T>& values, std::mt19937& random) {
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[random() % i]);
}

std::vector<int> shuffled_indices(std::size_t count, std::mt19937& random) {
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  shuffle(indices, random);
  return indices;
}

void shuffle_views_and_corners(CalibrationProblem& problem, std::mt19937& random) {
  shuffle(problem.views, random);
  for (TargetView& view : problem.views) shuffle(view.observations, random);
}

// new_place[i]: where the i-th frame or camera goes.
template <typename T>
std::vector<T> moved(const std::vector<T>& values, const std::vector<int>& new_place) {
  std::vector<T> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) result[new_place[i]] = values[i];
  return result;
}

void shuffle_frames(CalibrationProblem& problem, std::mt19937& random) {
  const std::vector<int> new_place = shuffled_indices(problem.frames.size(), random);
  problem.frames = moved(problem.frames, new_place);
  for (TargetView& view : problem.views) view.frame = new_place[view.frame];
}

const RigCamera& named(const CalibrationResult& result, const std::string& name) {
  return camera_named(result.calibration, name);
}

int used_corners(const CalibrationResult& result) {
  int used = 0;
  for (const CameraSummary& camera : result.cameras) used += camera.corners_used;
  return used;
}

TEST(CalibrateOrder, ViewsFramesAndCornersInAnyOrderGiveTheSameBits) {
  const CalibrationProblem problem = rig_problem();
  const CalibrationResult expected = calibrate(problem);
  std::mt19937 random(1);
  for (int trial = 0; trial < 2; ++trial) {
    CalibrationProblem other = problem;
    shuffle_frames(other, random);
    shuffle_views_and_corners(other, random);
    const CalibrationResult result = calibrate(other);
    for (const RigCamera& camera : expected.calibration.cameras) {
      EXPECT_EQ(named(result, camera.name).camera.parameters, camera.camera.parameters);
      EXPECT_EQ(named(result, camera.name).camera_from_rig.translation, camera.camera_from_rig.translation);
      EXPECT_EQ(named(result, camera.name).camera_from_rig.rotation.coeffs(), camera.camera_from_rig.rotation.coeffs());
    }
    EXPECT_EQ(result.calibration.covariance.matrix, expected.calibration.covariance.matrix);
    EXPECT_EQ(used_corners(result), used_corners(expected));
  }
}

// What belongs to views and corners comes back in the order in which they were given.
TEST(CalibrateOrder, FatesResidualsAndPosesBelongToWhatWasGiven) {
  const CalibrationProblem problem = rig_problem();
  const CalibrationResult expected = calibrate(problem);
  CalibrationProblem other = problem;
  std::mt19937 random(2);
  const std::vector<int> new_place = shuffled_indices(problem.views.size(), random);
  other.views = moved(problem.views, new_place);
  std::ranges::reverse(other.views[new_place[4]].observations);
  const CalibrationResult result = calibrate(other);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    ViewResult view = result.views[new_place[v]];
    if (v == 4) {
      std::ranges::reverse(view.fates);
      std::ranges::reverse(view.residuals_px);
    }
    EXPECT_EQ(view.fates, expected.views[v].fates);
    EXPECT_EQ(view.residuals_px, expected.views[v].residuals_px);
    ASSERT_EQ(view.pose < 0, expected.views[v].pose < 0);
    if (view.pose < 0) continue;
    EXPECT_EQ(result.poses[view.pose].frame, problem.views[v].frame);
    EXPECT_EQ(result.poses[view.pose].rig_from_target.translation,
              expected.poses[expected.views[v].pose].rig_from_target.translation);
  }
}

// The cameras' parameters change places in the linear systems: the same to rounding, no longer to the bit.
TEST(CalibrateOrder, CamerasInAnyOrderGiveTheSameResult) {
  const CalibrationProblem problem = rig_problem();
  const CalibrationResult expected = calibrate(problem);
  CalibrationProblem other = problem;
  const std::vector<int> new_place{0, 2, 1};  // the first one defines the rig frame
  other.cameras = moved(problem.cameras, new_place);
  for (TargetView& view : other.views) view.camera = new_place[view.camera];
  std::mt19937 random(3);
  shuffle_frames(other, random);
  shuffle_views_and_corners(other, random);
  const CalibrationResult result = calibrate(other);
  EXPECT_EQ(used_corners(result), used_corners(expected));
  for (const RigCamera& camera : expected.calibration.cameras) {
    const Eigen::ArrayXd found = named(result, camera.name).camera.parameters.array();
    const Eigen::ArrayXd wanted = camera.camera.parameters.array();
    EXPECT_LT(((found - wanted) / wanted.abs().max(1.0)).abs().maxCoeff(), 1e-9);
    const auto motion = motion_between(named(result, camera.name).camera_from_rig, camera.camera_from_rig);
    EXPECT_LT(motion.cwiseAbs().maxCoeff(), 1e-9);
  }
}

}  // namespace
}  // namespace raybundle
