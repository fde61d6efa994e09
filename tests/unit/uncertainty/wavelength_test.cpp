// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/wavelength.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "raybundle/scene/board_surface.hpp"

namespace raybundle {
namespace {

// A grating of 9 x 9 orders beside a fisheye camera; each beam lies a little off the grating's model.
Calibration rig_with_grating() {
  Calibration calibration;
  Camera camera{*model_named("kannala_brandt"), {640, 480}, Eigen::VectorXd(8)};
  camera.parameters << 282, 282, 320, 240, -0.01, 0.003, 0, 0;
  calibration.cameras.push_back({"camera", camera, {}});
  LaserPattern pattern;
  pattern.grid = {9, 9};
  pattern.grating.emplace();
  pattern.zero_order_row = pattern.zero_order_column = 4;
  pattern.grating->rig_from_projector.translation = {0.06, 0.0, 0.0};
  pattern.grating->column_pitch = pattern.grating->row_pitch = 0.12;
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      const Eigen::Vector4d off(1e-4 * (row - 4), -1e-4 * (column - 4), 3e-4 * ((row + column) % 3 - 1), 2e-4);
      pattern.beams.push_back({.row = row,
                               .column = column,
                               .line = perturbed(*beam_of_order(*pattern.grating, column - 4, row - 4), off)});
    }
  }
  calibration.laser = pattern;
  return calibration;
}

struct Seen {
  CalibrationProblem problem;
  std::vector<std::optional<Rigid3>> rig_from_target;
};

// Exact dots of the beams on two boards that face the camera.
Seen dots_of(const Calibration& calibration) {
  Seen seen;
  Target board{"board", {}, {}};
  for (const double x : {0.0, 1.0}) {
    for (const double y : {0.0, 1.0}) board.points.push_back({static_cast<int>(board.points.size()), {x, y, 0.0}});
  }
  seen.problem.targets.push_back(board);
  seen.problem.cameras.push_back(
      {"camera", calibration.cameras[0].camera.model, calibration.cameras[0].camera.size, {}, {}});
  for (const double depth_m : {0.5, 0.9}) {
    Rigid3 pose;
    pose.rotation = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
    pose.translation = {-0.5, 0.5, depth_m};
    TargetView view;
    view.frame = static_cast<int>(seen.rig_from_target.size());
    for (const LaserBeam& beam : calibration.laser->beams) {
      const Eigen::Vector3d place = beam.line.at((depth_m - beam.line.point.z()) / beam.line.direction.z());
      const auto pixel = pixel_from_ray(calibration.cameras[0].camera, place);
      if (!pixel) continue;
      view.dots.emplace_back().pixel = *pixel;
      view.dots.back().covariance_px2 = 0.01 * Eigen::Matrix2d::Identity();
    }
    seen.problem.views.push_back(view);
    seen.rig_from_target.push_back(pose);
  }
  return seen;
}

TEST(Wavelength, BeamsReturnWhenTheScaleDoes) {
  const LaserPattern pattern = *rig_with_grating().laser;
  const LaserPattern back = at_wavelength(at_wavelength(pattern, 1.01), 1.0);
  for (std::size_t i = 0; i < pattern.beams.size(); ++i) {
    EXPECT_LT(motion_between(pattern.beams[i].line, back.beams[i].line).norm(), 1e-12);
  }
}

TEST(Wavelength, IsRecoveredFromExactDots) {
  const Calibration cold = rig_with_grating();
  Calibration warm = cold;
  warm.laser = at_wavelength(*cold.laser, 1.0034);
  const Seen seen = dots_of(warm);
  const auto estimate = estimate_wavelength(cold, seen.problem, seen.rig_from_target);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->scale, 1.0034, 1e-8);
  EXPECT_GT(estimate->dots, 60);
}

// A fifth of the dots are reflections two pixels beside their beams.
TEST(Wavelength, OutliersDoNotDragIt) {
  const Calibration cold = rig_with_grating();
  Calibration warm = cold;
  warm.laser = at_wavelength(*cold.laser, 0.998);
  Seen seen = dots_of(warm);
  for (TargetView& view : seen.problem.views) {
    for (std::size_t i = 0; i < view.dots.size(); i += 5) view.dots[i].pixel += Eigen::Vector2d(1.5, 1.4);
  }
  const auto estimate = estimate_wavelength(cold, seen.problem, seen.rig_from_target);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->scale, 0.998, 1e-6);
}

TEST(Wavelength, FewDotsSayNothing) {
  const Calibration cold = rig_with_grating();
  Seen seen = dots_of(cold);
  seen.problem.views.resize(1);
  seen.rig_from_target.resize(1);
  seen.problem.views[0].dots.resize(9);
  EXPECT_FALSE(estimate_wavelength(cold, seen.problem, seen.rig_from_target));
}

}  // namespace
}  // namespace raybundle
