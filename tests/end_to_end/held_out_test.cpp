// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "held_out.hpp"

#include <gtest/gtest.h>

#include "synthetic_world.hpp"

namespace raybundle::testing {
namespace {

// Of boards that differ in their codes only, each has the bend that was found under its name.
TEST(HeldOut, BendsEachBoardAsItWasFound) {
  SyntheticOptions options;
  options.boards = 2;
  const SyntheticWorld world = synthetic_world(options);
  CalibrationFile file;
  file.calibration.cameras = {{world.problem.cameras[0].name, world.cameras[0], {}}};
  for (const double bend_m : {0.006, -0.006}) {
    BoardShape shape;
    shape.bend_x_m = bend_m;
    file.calibration.targets.push_back({world.problem.targets[file.calibration.targets.size()], shape});
  }
  const apps::HeldOut held = apps::held_out(file, world.problem);
  for (std::size_t t = 0; t < 2; ++t) {
    const CalibratedTarget& known = file.calibration.targets[t];
    const std::vector<Eigen::Vector3d> bent = points_on_surface(known.target, known.shape);
    for (std::size_t i = 0; i < bent.size(); ++i) {
      EXPECT_EQ(held.problem.targets[t].points[i].x_in_target, bent[i]) << t;
    }
  }
}

}  // namespace
}  // namespace raybundle::testing
