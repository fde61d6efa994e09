// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/result.hpp"

#include <gtest/gtest.h>

namespace raybundle {
namespace {

TEST(LaserSummary, DragIsTheLargestMoveInSigmasAndIgnoresWhatWasHeld) {
  LaserSummary laser;
  EXPECT_EQ(drag_sigmas(laser.parameters), 0.0);
  laser.parameters = {{"left.fx", 300.0, 300.2, 0.1}, {"left.cx", 320.0, 319.5, 0.1}, {"left.k4", 0.0, 1.0, 0.0}};
  EXPECT_NEAR(drag_sigmas(laser.parameters), 5.0, 1e-9);
}

}  // namespace
}  // namespace raybundle
