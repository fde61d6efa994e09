// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/sensor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace raybundle {
namespace {

// Odd grids have a bright order zero amid their beams; even ones have none, not even between them.
TEST(StructuredLightSensor, MakesTheBeamsOfItsGridAndNoOther) {
  for (const LaserGrid grid : {LaserGrid{11, 11}, LaserGrid{16, 19}}) {
    const CabinSensor sensor = structured_light_sensor(CockpitGenerator::kTraining, 1, grid);
    const std::vector<EmittedBeam> beams = beams_of(*sensor.rig.emitter);
    EXPECT_EQ(static_cast<int>(beams.size()), grid.size());
    EXPECT_TRUE(std::ranges::all_of(beams, &EmittedBeam::labelled));
  }
}

}  // namespace
}  // namespace raybundle
