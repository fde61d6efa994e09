// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>

#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/observations_file.hpp"
#include "synthetic_world.hpp"

namespace raybundle::testing {

/// A transform whose digits do not end.
inline Rigid3 awkward_rigid3(double seed) {
  Rigid3 transform;
  transform.rotation = Eigen::Quaterniond(1.0, 0.1 * seed, -1.0 / 3.0, 0.7 / seed).normalized();
  transform.translation = {seed / 7.0, -1e-3 / 3.0, -0.0};
  return transform;
}

/// One camera for each example of each model of the list.
inline std::vector<RigCamera> camera_of_every_example() {
  std::vector<RigCamera> cameras;
  Models::for_each([&]<CameraModel M>() {
    for (std::size_t i = 0; i < M::kExamples.size(); ++i) {
      Camera camera = start_camera(*model_named(M::kName), {1280, 961}, 1000.0 / 3.0);
      for (int k = 0; k < kShapeSize<M>; ++k) camera.parameters[4 + k] = M::kExamples[i].shape[k];
      const auto number = static_cast<double>(cameras.size() + 1);
      cameras.push_back({std::string(M::kName) + "_" + std::to_string(i), camera, awkward_rigid3(number)});
    }
  });
  return cameras;
}

/// Three of six beams, and their grating.
inline LaserPattern small_pattern() {
  LaserPattern pattern{{2, 3}, {}, Grating{}, 0.5, 1.0};
  pattern.grating->rig_from_projector = awkward_rigid3(3);
  pattern.grating->column_pitch = 0.1 / 3.0;
  pattern.grating->wavelength_scale = 1.0 + 1e-3 / 3.0;
  for (const int beam : {0, 2, 4}) {
    LaserBeam each{pattern.grid.row(beam), pattern.grid.column(beam), {}};
    each.line = {{0.1 * beam / 3.0, -0.2, 0.7}, Eigen::Vector3d(0.1 * beam, 1.0 / 3.0, 1.0).normalized()};
    each.covariance = Eigen::Vector4d(1e-7, 2e-7, 1e-6 / 3.0, 4e-7).asDiagonal();
    each.covariance(0, 2) = each.covariance(2, 0) = 1e-8 / 3.0;
    each.hits = 10 + beam;
    each.nearest_hit_m = 0.1 + 0.2;
    each.farthest_hit_m = 1.0;
    pattern.beams.push_back(each);
  }
  return pattern;
}

/// A calibration that uses every part of the format.
inline CalibrationFile full_calibration() {
  CalibrationFile file;
  Calibration& calibration = file.calibration;
  calibration.cameras = camera_of_every_example();
  Target board = grid_target("board", 4, 3, 0.1 / 3.0);
  TargetSymmetry turned;
  for (int id = 11; id >= 0; --id) turned.ids.push_back(id);
  board.symmetries = {turned};
  calibration.targets = {{board, {1e-4 / 3.0, -2e-4, 5e-324}}};
  const std::string first = calibration.cameras[0].name;
  calibration.covariance.names = {first + ".fx", first + ".camera_from_rig.rotation_x", "board.bend_x"};
  calibration.covariance.matrix = Eigen::Matrix3d{{1.0 / 3.0, 1e-9, -0.1}, {1e-9, 2e-7, 1e-12}, {-0.1, 1e-12, 0.7}};
  calibration.covariance_by_frame = {calibration.covariance.names, 1.7 * calibration.covariance.matrix};
  CornerEvidence evidence{2, 1, {3, 0}, {}};
  evidence.implied_motion.setConstant(6, calibration.cameras[0].camera.parameters.size(), 0.1 / 3.0);
  calibration.cameras[0].evidence = evidence;
  calibration.laser = small_pattern();
  file.rms_px = 0.1 + 0.2;
  file.variance_factor = 1.0 / 7.0;
  for (std::size_t i = 0; i < calibration.cameras.size(); ++i) {
    const int n = static_cast<int>(i);
    file.summaries.push_back({0.1 * n / 3.0, 0.05, 10 + n, 20 + n, 1000 - n, n});
  }
  file.provenance = {"raybundle calibrate \"dataset.toml\"",
                     {{"left01.jpg", std::string(64, 'a')}, {"right01.jpg", std::string(64, 'b')}},
                     {{"threads", "2"}, {"outlier_sigma", "5"}},
                     {{"raybundle", "0.1.0"}, {"ceres", "2.1.0"}}};
  return file;
}

/// Two cameras, two boards, a few views.
inline ObservationsFile small_observations() {
  SyntheticOptions options = stereo_head();
  options.columns = 4;
  options.rows = 3;
  options.boards = 2;
  options.frames = 3;
  options.noise_px = 0.3;
  ObservationsFile file;
  file.problem = synthetic_world(options).problem;
  for (ProblemCamera& camera : file.problem.cameras) {
    camera.parameters.reset();
    camera.camera_from_rig.reset();
    camera.model = ModelId{};
  }
  file.models.assign(file.problem.cameras.size(), std::nullopt);
  ProblemLaser laser{{2, 3}};
  laser.anchor = LaserAnchor{0, {10.1, 1.0 / 3.0}, 4};
  laser.brightest = 4;
  laser.missing = {5, 1};
  file.problem.laser = laser;
  Eigen::Matrix2d covariance;
  covariance << 0.01, 1e-3 / 3.0, 1e-3 / 3.0, 0.02;
  file.problem.views[0].dots = {{{100.1, 200.2}, covariance, 4, 1000.0 / 3.0}, {{10.1, 1.0 / 3.0}, covariance}};
  file.models[1] = file.problem.cameras[1].model = *model_named("kannala_brandt");
  return file;
}

/// The message of the Error that an action throws; fails the test when it throws none, or of another kind.
inline std::string message_of(const std::function<void()>& action, ErrorKind kind = ErrorKind::kBadInput) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "not a raybundle::Error: " << error.what();
    return "";
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

/// The text with the first `from` replaced; the test fails when there is none.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << "the text does not hold " << from;
  return place == std::string::npos ? text : text.replace(place, from.size(), to);
}

}  // namespace raybundle::testing
