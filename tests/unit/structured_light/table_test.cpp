// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/parameter_names.hpp"
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

// A beam is as uncertain as it is on the rig, and as the camera's place on the rig makes it; the first camera is the rig.
TEST(SensorTable, CountsTheUncertainPlaceOfACameraThatIsNotTheFirst) {
  constexpr double kBeamSigma = 1e-4;
  testing::SensorWorld world = sensor_world({3, 3}, 12.0, kBeamSigma);
  RigCamera right{"right", world.camera.camera, {}};
  right.camera_from_rig = {Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d(2, 1, 2) / 3.0)),
                           {0.2, 0.1, 0.05}};
  world.calibration.cameras.push_back(right);
  Eigen::MatrixXd root(6, 6);
  Random random(2);
  for (double& number : root.reshaped()) number = 1e-4 * random.normal();
  world.calibration.covariance = {extrinsic_names(right), root * root.transpose()};

  const SensorTable of_first = sensor_table(world.calibration, "", {}, "a test");
  const SensorTable of_right = sensor_table(world.calibration, "right", {}, "a test");
  EXPECT_EQ(of_first.shared_covariance.norm(), 0.0);
  for (std::size_t b = 0; b < of_right.beams.size(); ++b) {
    const Line3 &line = of_right.beams[b].line, &in_rig = world.calibration.laser->beams[b].line;
    Eigen::Matrix<double, 4, 6> by_place;
    for (int i = 0; i < 6; ++i) {
      constexpr double kStep = 1e-6;
      const Eigen::Matrix<double, 6, 1> step = kStep * Eigen::Matrix<double, 6, 1>::Unit(i);
      by_place.col(i) = motion_between(line, perturbed(right.camera_from_rig, step) * in_rig) / kStep;
    }
    // Equal variances of offsets and slopes on the rig are so in the camera, too.
    const Eigen::Matrix4d expected = kBeamSigma * kBeamSigma * Eigen::Matrix4d::Identity() +
                                     by_place * world.calibration.covariance.matrix * by_place.transpose();
    EXPECT_LT((of_right.beams[b].covariance - expected).norm(), 1e-4 * expected.norm()) << b;  // one-sided steps
  }
  const SensorTable again = table_from_bytes(bytes_from_table(of_right), "table");
  EXPECT_EQ(again.shared_covariance, of_right.shared_covariance);
}

TEST(SensorTable, SaysWhatItNeeds) {
  testing::SensorWorld world = sensor_world({3, 3}, 12.0);
  world.calibration.laser->grid = {200, 200};  // more beams than are counted in 16 bits
  EXPECT_THROW(sensor_table(world.calibration, "", {}, ""), Error);
  world.calibration.laser->grid = {3, 3};
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

// Long lenses near a far projector: a beam's dots cross a corner of the image between two places far outside of it.
TEST(SensorTable, ListsBeamsThatCrossACornerOfTheImage) {
  testing::SensorWorld world = sensor_world({11, 11}, 12.0);
  RigCamera& camera = world.calibration.cameras.front();
  camera.camera = start_camera(*model_named("pinhole"), {640, 480}, 2000.0);
  for (LaserBeam& beam : world.calibration.laser->beams) beam.line.point.x() += 0.3;
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  int seen = 0;
  for (std::size_t b = 0; b < table.beams.size(); ++b) {
    const Line3& line = table.beams[b].line;
    for (int i = 0; i <= 20000; ++i) {
      const double depth = 1.0 / (1.0 / 1.5 + (1.0 / 0.15 - 1.0 / 1.5) * i / 20000);
      const auto pixel = pixel_from_ray(camera.camera, line.at((depth - line.point.z()) / line.direction.z()));
      if (!pixel || !camera.camera.size.contains(*pixel)) continue;
      ++seen;
      const auto listed = table.candidates.at(*pixel);
      ASSERT_EQ(std::ranges::count(listed, static_cast<int>(b)), 1) << "beam " << b << " at " << depth << " m";
    }
  }
  EXPECT_GT(seen, 1000);
}

}  // namespace
}  // namespace raybundle
