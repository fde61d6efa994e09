// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "raybundle/geometry/error.hpp"
#include "raybundle/structured_light/beam_geometry.hpp"
#include "raybundle/structured_light/table_file.hpp"
#include "worlds.hpp"

namespace raybundle {
namespace {

using testing::sensor_world;

// A table of few bytes: a small image, three by three beams of which it sees the middle.
SensorTable small_table() {
  testing::SensorWorld world = sensor_world({3, 3}, 12.0);
  world.camera.camera = start_camera(*model_named("pinhole"), {48, 32}, 60.0);
  world.calibration.cameras = {world.camera};
  return sensor_table(world.calibration, "", {}, "a test");
}

TEST(RayTable, KeepsItsStatedErrorForEveryModel) {
  for (const std::string_view name : model_names()) {
    const Camera camera = start_camera(*model_named(name), {640, 480}, 420.0);
    const RayTable table = ray_table(camera);
    EXPECT_LE(table.error_rad, 1e-4) << name;
    Random random(1);
    int compared = 0;
    for (int i = 0; i < 2000; ++i) {
      const double u = random.uniform(0.0, 639.0), v = random.uniform(0.0, 479.0);
      const auto exact = ray_from_pixel(camera, {u, v});
      const RayTable::Ray ray = table.at({u, v});
      if (!exact || std::isnan(ray.direction.x())) continue;
      ++compared;
      EXPECT_LE((ray.direction - *exact).norm(), table.error_rad) << name << " at " << u << ", " << v;
      // Its derivative is that of the lens: a step of a pixel agrees to the second order.
      const auto next = ray_from_pixel(camera, {u + 0.01, v});
      EXPECT_LE(((*next - *exact) / 0.01 - ray.per_px.col(0)).norm(), 1e-2 * ray.per_px.col(0).norm()) << name;
    }
    EXPECT_GT(compared, 1000) << name;
  }
}

TEST(SensorTable, GivesBackWhatWasWritten) {
  const SensorTable table = sensor_table(sensor_world({11, 11}, 12.0).calibration, "", {}, "a test");
  const std::string bytes = bytes_from_table(table);
  const SensorTable again = table_from_bytes(bytes, "table");
  EXPECT_EQ(bytes_from_table(again), bytes);
  EXPECT_EQ(again.serial.size(), 16U);
  EXPECT_GE(again.self_tests.size(), 50U);
}

TEST(SensorTable, RefusesEveryFlippedBitAndEveryTruncation) {
  const std::string bytes = bytes_from_table(small_table());
  ASSERT_NO_THROW(table_from_bytes(bytes, "table"));
  for (std::size_t byte = 0; byte < bytes.size(); ++byte) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = bytes;
      damaged[byte] = static_cast<char>(damaged[byte] ^ 1 << bit);
      ASSERT_THROW(table_from_bytes(damaged, "table"), Error) << "byte " << byte << ", bit " << bit;
    }
  }
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_THROW(table_from_bytes(bytes.substr(0, size), "table"), Error) << size << " bytes";
  }
}

TEST(SensorTable, FailsItsSelfTestWhenABeamIsAnother) {
  SensorTable table = sensor_table(sensor_world({11, 11}, 12.0).calibration, "", {}, "a test");
  table.beams[table.self_tests[3].beam].line.direction =
      (table.beams[table.self_tests[3].beam].line.direction + Eigen::Vector3d(1e-3, 1e-3, 0)).normalized();
  EXPECT_THROW(table_from_bytes(bytes_from_table(table), "table"), Error);
}

TEST(SensorTable, SaysWhatItNeeds) {
  testing::SensorWorld world = sensor_world({3, 3}, 12.0);
  EXPECT_THROW(sensor_table(world.calibration, "", {.nearest_m = 2.0, .farthest_m = 1.0}, ""), Error);
  EXPECT_THROW(sensor_table(world.calibration, "other", {}, ""), Error);
  world.calibration.laser.reset();
  EXPECT_THROW(sensor_table(world.calibration, "", {}, ""), Error);
}

TEST(SensorTable, ListsEveryBeamWhereItsDotsAreSeen) {
  const testing::SensorWorld world = sensor_world({16, 19}, 14.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  Random random(3);
  for (int i = 0; i < 5000; ++i) {
    const int beam = random.below(static_cast<int>(table.beams.size()));
    const Line3& line = table.beams[beam].line;
    const double depth = 1.0 / random.uniform(1.0 / 1.5, 1.0 / 0.15);
    const auto pixel = pixel_from_ray(world.camera.camera, line.at((depth - line.point.z()) / line.direction.z()));
    if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 639 || pixel->y() > 479) continue;
    const auto listed = table.candidates.at(*pixel);
    EXPECT_TRUE(std::ranges::count(listed, beam) == 1) << "beam " << beam << " at " << depth << " m";
  }
}

}  // namespace
}  // namespace raybundle
