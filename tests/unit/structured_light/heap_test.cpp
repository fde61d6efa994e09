// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include "heap_calls.hpp"
#include "raybundle/structured_light/structured_light.hpp"
#include "spot_image.hpp"
#include "worlds.hpp"

namespace raybundle {
namespace {

TEST(StructuredLight, TakesNoMemoryAfterItsStart) {
  const testing::SensorWorld world = testing::sensor_world({16, 19}, 12.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  std::vector<testing::SpotImage> images;
  for (int s = 0; s < 3; ++s) {
    Random random(1, s);
    const auto dots = dots_in(testing::CabinScene(s), world.camera, world.beams, table.grid, {}, random);
    images.emplace_back(table.rays.size, dots, true, testing::LightOptions{}, random);
  }
  for (const Labeller& labeller : kLabellers) {
    StructuredLight sensor(table, {.labeller = labeller, .dots = {}, .health = {}});
    const long before = testing::heap_calls;
    std::size_t points = 0;
    for (const testing::SpotImage& image : images) points += sensor.process(image.view()).points.size();
    EXPECT_EQ(testing::heap_calls - before, 0) << labeller.name;
    EXPECT_GT(points, 300U) << labeller.name;
  }
}

}  // namespace
}  // namespace raybundle
