// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "raybundle/geometry/error.hpp"
#include "raybundle/structured_light/structured_light.hpp"
#include "worlds.hpp"

namespace raybundle {
namespace {

using testing::CabinScene;
using testing::SceneDot;
using testing::sensor_world;
using testing::SensorWorld;

struct Count {
  int right = 0, wrong = 0, possible = 0;
};

std::vector<Dot> plain(const std::vector<SceneDot>& dots) {
  std::vector<Dot> plain;
  for (const SceneDot& dot : dots) plain.push_back(dot.dot);
  return plain;
}

Count labelled(const SensorWorld& world, const Labeller& labeller, int scenes) {
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  StructuredLight sensor(table, {.labeller = labeller, .dots = {}, .health = {}});
  Count count;
  for (int s = 0; s < scenes; ++s) {
    Random random(5, s);
    const auto dots = dots_in(CabinScene(s), world.camera, world.beams, table.grid, {}, random);
    const LaserFrame& frame = sensor.process(plain(dots));
    for (std::size_t i = 0; i < dots.size(); ++i) {
      const double depth = dots[i].x_in_camera.z();
      const bool possible = dots[i].beam >= 0 && depth >= table.range.nearest_m && depth <= table.range.farthest_m;
      count.possible += possible;
      if (frame.dots[i].beam == kUnlabelled) continue;
      possible&& frame.dots[i].beam == dots[i].beam ? ++count.right : ++count.wrong;
    }
  }
  return count;
}

TEST(Labels, OfEveryLabellerAreRightOrNone) {
  for (const Labeller& labeller : kLabellers) {
    const Count count = labelled(sensor_world({11, 11}, 13.0), labeller, 10);
    EXPECT_LE(count.wrong, 3) << labeller.name << ": of " << count.possible;  // ./dev prove labels has the figures
    EXPECT_GE(count.right, 0.95 * count.possible) << labeller.name;
  }
}

TEST(Labels, AreNotGuessedWhereBeamsShareTheirEpipolarPlanes) {
  const Count count = labelled(sensor_world({11, 11}, 0.0), kLabellers.front(), 10);
  EXPECT_LE(count.wrong, 0.01 * (count.right + count.wrong));
}

TEST(Labels, AreNotGivenToDotsThatAreNearerThanTheSensorMeasures) {
  const SensorWorld world = sensor_world({16, 19}, 13.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  StructuredLight sensor(table);
  for (const double depth_m : {0.08, 0.1, 0.13}) {
    std::vector<Dot> dots;
    for (const TableBeam& beam : table.beams) {
      const Line3& line = beam.line;
      const auto pixel = pixel_from_ray(world.camera.camera, line.at((depth_m - line.point.z()) / line.direction.z()));
      if (pixel && (pixel->array() > 0.0).all() && pixel->x() < 639.0 && pixel->y() < 479.0) {
        dots.push_back({*pixel, 0.01 * Eigen::Matrix2d::Identity(), kUnlabelled, 0.0});
      }
    }
    ASSERT_GT(dots.size(), 100u);
    EXPECT_TRUE(sensor.process(dots).points.empty()) << depth_m;
  }
}

TEST(Labels, AreNotGivenToDotsBesideTheImage) {
  const SensorWorld world = sensor_world({11, 11}, 13.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  StructuredLight sensor(table);
  std::vector<Dot> dots;
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(100, 1e6), Eigen::Vector2d(-1e9, 5), Eigen::Vector2d(641, 3),
                                       Eigen::Vector2d(std::nan(""), 3), Eigen::Vector2d(3, INFINITY)}) {
    dots.push_back({pixel, 0.01 * Eigen::Matrix2d::Identity(), kUnlabelled, 0.0});
  }
  const LaserFrame& frame = sensor.process(dots);
  EXPECT_TRUE(frame.points.empty());
  EXPECT_EQ(frame.dots.size(), dots.size());
  EXPECT_THROW(StructuredLight(table, {.dots = {}, .health = {.window = 0}}), Error);
}

TEST(LaserPoint, LiesOnItsBeamAndScattersAsItsCovarianceSays) {
  const SensorWorld world = sensor_world({11, 11}, 12.0, 2e-4);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  const TableBeam& truth = table.beams[40];
  const Eigen::Vector3d x = truth.line.at((0.8 - truth.line.point.z()) / truth.line.direction.z());
  const Eigen::Vector2d pixel = *pixel_from_ray(world.camera.camera, x);
  const Eigen::Matrix2d noise = (Eigen::Matrix2d() << 0.02, 0.005, 0.005, 0.01).finished();
  const Eigen::Matrix2d root = noise.llt().matrixL();
  Random random(4);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 4000;
  const LaserPoint middle = laser_point(truth, beam_geometry(truth), table.rays.at(pixel), noise);
  EXPECT_LT((middle.x_in_camera - x).norm(), 1e-4);  // the table's rays are within 2e-6 rad
  for (int i = 0; i < kDraws; ++i) {
    TableBeam beam = truth;
    Eigen::Vector4d motion;
    for (double& number : motion) number = 2e-4 * random.normal();
    beam.line = perturbed(truth.line, motion);
    const double a = random.normal(), b = random.normal();
    const Eigen::Vector2d seen = pixel + root * Eigen::Vector2d(a, b);
    const LaserPoint point = laser_point(beam, beam_geometry(beam), table.rays.at(seen), noise);
    EXPECT_LT(distance_between(beam.line, point.x_in_camera), 1e-12);
    const Eigen::Vector3d off = point.x_in_camera - x;
    scatter += off * off.transpose() / kDraws;
  }
  // 4000 draws: 2.2 % of a variance; three sigmas and the second order of the triangulation.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(scatter(i, i) / middle.covariance(i, i), 1.0, 0.1) << "axis " << i;
}

TEST(StructuredLight, GivesTheSameBitsAndRefusesImagesOfAnotherSize) {
  const SensorWorld world = sensor_world({11, 11}, 12.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  StructuredLight one(table), two(table);
  Random random(6);
  const auto dots = plain(dots_in(CabinScene(1), world.camera, world.beams, table.grid, {}, random));
  const LaserFrame& a = one.process(dots);
  const LaserFrame& b = two.process(dots);
  ASSERT_EQ(a.points.size(), b.points.size());
  ASSERT_GT(a.points.size(), 50U);
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].x_in_camera, b.points[i].x_in_camera);
    EXPECT_EQ(a.points[i].covariance, b.points[i].covariance);
  }
  const std::vector<std::uint8_t> pixels(100);
  EXPECT_EQ(one.process(GreyView{pixels.data(), 10, 10, 10}).state, State::kInvalid);
}

TEST(Mesh, SpansASurfaceButNoJump) {
  const SensorWorld world = sensor_world({11, 11}, 12.0);
  const SensorTable table = sensor_table(world.calibration, "", {}, "a test");
  const BeamLattice lattice(table);
  std::vector<LaserPoint> points;
  std::vector<int> point_of_beam;
  for (std::size_t b = 0; b < table.beams.size(); ++b) {
    const Line3& line = table.beams[b].line;
    const double depth = table.beams[b].column < 5 ? 0.5 : 1.2;  // two planes
    LaserPoint point;
    point.beam = static_cast<int>(b);
    point.x_in_camera = line.at((depth - line.point.z()) / line.direction.z());
    point_of_beam.push_back(static_cast<int>(points.size()));
    points.push_back(point);
  }
  std::vector<Triangle> triangles;
  mesh(lattice, points, point_of_beam, 6.0, triangles);
  EXPECT_EQ(triangles.size(), 2U * 10 * 9);  // ten rows of squares, all columns but the one across the jump
  for (const Triangle& triangle : triangles) {
    const Eigen::Vector3d &a = points[triangle.a].x_in_camera, &b = points[triangle.b].x_in_camera,
                          &c = points[triangle.c].x_in_camera;
    EXPECT_NEAR(a.z(), b.z(), 1e-9);
    EXPECT_NEAR(a.z(), c.z(), 1e-9);
    EXPECT_LT((b - a).cross(c - a).z(), 0.0);  // faces the camera
  }
}

}  // namespace
}  // namespace raybundle
