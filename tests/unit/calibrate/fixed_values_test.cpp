// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Parameters that a rule keeps at a value.
#include <gmock/gmock.h>

#include "raybundle/calibrate/calibrate.hpp"
#include "synthetic_world.hpp"

namespace raybundle {
namespace {

using testing::synthetic_world;
using testing::SyntheticOptions;

// Whatever the data say: intrinsics, residuals and shape of the result belong together.
TEST(FixedValues, AShapeThatIsGivenHolds) {
  SyntheticOptions options;
  options.noise_px = 0.2;
  CalibrationProblem problem = synthetic_world(options).problem;
  for (const auto kind : {ParameterRule::Kind::kFixed, ParameterRule::Kind::kPrior}) {
    problem.rules = {{"board0.bend_y", kind, 0.0004, 1e-9}};
    EXPECT_NEAR(calibrate(problem).calibration.targets[0].shape.bend_y_m, 0.0004, 1e-6);
  }
}

TEST(FixedValues, KeepsFixedParameters) {
  SyntheticOptions options;
  options.noise_px = 0.2;
  CalibrationProblem problem = synthetic_world(options).problem;
  problem.rules = {{"camera0.k4", ParameterRule::Kind::kFixed, 0.0, 0.0}};
  const CalibrationResult result = calibrate(problem);
  EXPECT_EQ(result.calibration.cameras[0].camera.parameters[7], 0.0);
}

TEST(FixedValues, NamesAValueThatCornersContradict) {
  SyntheticOptions options;
  options.noise_px = 0.2;
  CalibrationProblem problem = synthetic_world(options).problem;
  const double cx = calibrate(problem).calibration.cameras[0].camera.cx();
  for (const double off_px : {0.0, 40.0}) {
    problem.rules = {{"camera0.cx", ParameterRule::Kind::kFixed, cx + off_px, 0.0}};
    const auto names_it = ::testing::Contains(::testing::HasSubstr("camera0.cx is kept at"));
    const bool named = ::testing::Value(calibrate(problem).warnings, names_it);
    EXPECT_EQ(named, off_px > 0.0);
  }
}

}  // namespace
}  // namespace raybundle
