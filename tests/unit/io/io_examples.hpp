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
  SyntheticOptions options;
  options.cameras.resize(2);
  options.cameras[1].camera_from_rig.translation = {-0.1, 0, 0};
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
