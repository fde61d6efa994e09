// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// What ships on a device takes its memory at the start: this binary counts every call of operator new.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "raybundle/structured_light/structured_light.hpp"
#include "spot_image.hpp"
#include "worlds.hpp"

namespace {
std::atomic<long> heap_calls{0};
}

void* operator new(std::size_t size) {
  ++heap_calls;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

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
    const long before = heap_calls;
    std::size_t points = 0;
    for (const testing::SpotImage& image : images) points += sensor.process(image.view()).points.size();
    EXPECT_EQ(heap_calls - before, 0) << labeller.name;
    EXPECT_GT(points, 300U) << labeller.name;
  }
}

}  // namespace
}  // namespace raybundle
