// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/cabin_renderer.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "raybundle/cockpit/dots.hpp"

namespace raybundle {
namespace {

CabinScene passenger(CockpitGenerator generator, std::uint64_t seed = 2) {
  return CabinScene(make_cockpit({generator, seed, CabinClass::kPassenger}));
}

constexpr CockpitGenerator kBoth[] = {CockpitGenerator::kTraining, CockpitGenerator::kTest};

TEST(CabinScene, MeetsTheNearestSurfaceAndKnowsItsShadows) {
  const CabinScene scene = passenger(CockpitGenerator::kTraining);
  const Eigen::Vector3d head = scene.cockpit().truth.head->centre, eye(0.45, 0.30, 0.90);
  const auto hit = scene.first_hit(eye, (head - eye).normalized());
  ASSERT_TRUE(hit);
  EXPECT_EQ(scene.cockpit().meshes[hit->mesh].part, CabinPart::kHead);
  EXPECT_LT(hit->distance_m, (head - eye).norm());
  EXPECT_NEAR(hit->normal.norm(), 1, 1e-6);
  EXPECT_LT(hit->normal.dot(head - eye), 0);
  EXPECT_TRUE(scene.blocked(eye, head + 0.3 * (head - eye)));
  EXPECT_FALSE(scene.blocked(eye, hit->x_in_vehicle));
  const CabinHit from = *hit;
  std::uint8_t dark = 0;
  scene.blocked({&from, 1}, eye, {&dark, 1});
  EXPECT_FALSE(dark);
  scene.blocked({&from, 1}, head + 0.3 * (head - eye), {&dark, 1});
  EXPECT_TRUE(dark);
}

TEST(Dots, LieOnTheSurfacesThatBeamAndCameraSee) {
  for (const CockpitGenerator generator : kBoth) {
    const CabinScene scene = passenger(generator);
    const CabinSensor sensor = structured_light_sensor(generator, 3);
    const std::vector<CabinDot> dots = dots_of(scene, sensor);
    EXPECT_GT(dots.size(), 50u);
    const Rigid3 camera_from_vehicle = sensor.vehicle_from_rig.inverse();
    for (const CabinDot& dot : dots) {
      const Eigen::Vector3d eye = sensor.vehicle_from_rig.translation;
      const auto seen = scene.first_hit(eye, (dot.x_in_vehicle - eye).normalized());
      ASSERT_TRUE(seen);
      // Embree's single precision, and the millimetre within which surfaces cast no shadow on themselves.
      EXPECT_LT((seen->x_in_vehicle - dot.x_in_vehicle).norm(), 0.02);
      const auto pixel = pixel_from_ray(sensor.rig.cameras[0].camera, camera_from_vehicle * dot.x_in_vehicle);
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - dot.true_pixel).norm(), 1e-6);
    }
  }
}

TEST(Dots, ErrAsTheirCovarianceSays) {
  double squares = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const CabinScene scene = passenger(CockpitGenerator::kTraining, seed);
    const CabinSensor sensor = structured_light_sensor(CockpitGenerator::kTraining, seed);
    for (const CabinDot& dot : dots_of(scene, sensor, {.seed = seed})) {
      const Eigen::Vector2d error = dot.dot.pixel - dot.true_pixel;
      const double square = error.dot(dot.dot.covariance_px2.inverse() * error);
      if (square > 30) continue;  // an edge cuts the spot
      squares += square;
      ++count;
    }
  }
  EXPECT_NEAR(squares / (2 * count), 1.0, 0.12);  // 4 standard deviations of the mean of 1000 chi-squares
}

// What the fast way predicts is what the slow way renders.
TEST(Dots, HaveTheLightThatTheirImageHas) {
  const CockpitGenerator generator = CockpitGenerator::kTest;
  const CabinScene scene = passenger(generator);
  const CabinRenderer renderer(structured_light_sensor(generator, 3));
  const GreyImage off = renderer.image(scene, 0, {.noise = false, .samples = 1});
  const GreyImage on = renderer.image(scene, 0, {.noise = false, .laser = true, .samples = 1});
  std::vector<double> ratios, offsets_px;
  for (const CabinDot& dot : dots_of(scene, renderer.sensor())) {
    constexpr int kReach = 4;
    const Eigen::Vector2i middle = dot.true_pixel.array().round().cast<int>();
    if ((middle.array() < kReach).any() || middle.x() > 635 || middle.y() > 475) continue;
    double sum = 0;
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    for (int y = middle.y() - kReach; y <= middle.y() + kReach; ++y) {
      for (int x = middle.x() - kReach; x <= middle.x() + kReach; ++x) {
        const double light = on.at(x, y) - off.at(x, y);
        sum += light;
        moment += light * Eigen::Vector2d(x, y);
      }
    }
    if (dot.dot.brightness < 60) continue;  // rounding to grey values weighs too much
    ratios.push_back(sum / dot.dot.brightness);
    offsets_px.push_back((moment / sum - dot.true_pixel).norm());
  }
  ASSERT_GT(ratios.size(), 20u);
  std::ranges::sort(ratios);
  std::ranges::sort(offsets_px);
  EXPECT_NEAR(ratios[ratios.size() / 2], 1.0,
              0.06);  // 2 % of a beam's power lie beyond the footprint, more in rounding
  EXPECT_LT(offsets_px[offsets_px.size() / 2], 0.12);  // patterns of the surface within a spot
}

TEST(Stereo, PairsShowTheSameSceneWithTheSameBits) {
  const CabinRenderer renderer(stereo_sensor(CockpitGenerator::kTraining, 1, {96, 96}));
  const CabinScene scene = passenger(CockpitGenerator::kTraining);
  const GreyImage left = renderer.image(scene, 0), again = renderer.image(scene, 0);
  EXPECT_EQ(left.values, again.values);
  EXPECT_NE(left.values, renderer.image(scene, 0, {.stream = 1}).values);
  // A place that both cameras see is about as bright in both.
  const GreyImage right = renderer.image(scene, 1);
  const CabinDepth depth = renderer.depth(scene, 0);
  const CabinSensor& sensor = renderer.sensor();
  const SimulatedCamera& other = sensor.rig.cameras[1];
  const Rigid3 other_from_vehicle = other.camera_from_rig * sensor.vehicle_from_rig.inverse();
  double product = 0, left_square = 0, right_square = 0;
  for (int i = 0; i < 96 * 96; ++i) {
    const CabinHit& hit = depth.hits[static_cast<std::size_t>(i)];
    if (hit.mesh < 0) continue;
    const auto pixel = pixel_from_ray(other.camera, other_from_vehicle * hit.x_in_vehicle);
    if (!pixel || (pixel->array() < 1).any() || (pixel->array() > 94).any()) continue;
    const double a = left.values[static_cast<std::size_t>(i)],
                 b = right.at(static_cast<int>(std::lround(pixel->x())), static_cast<int>(std::lround(pixel->y())));
    product += a * b;
    left_square += a * a;
    right_square += b * b;
  }
  EXPECT_GT(product / std::sqrt(left_square * right_square), 0.9);
}

TEST(Head, CentroidOfWhatIsSeenLiesBetweenCentreAndCamera) {
  for (const CockpitGenerator generator : kBoth) {
    const CabinRenderer renderer(stereo_sensor(generator, 5));
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const CabinScene scene = passenger(generator, seed);
      const Eigen::Vector3d eye = renderer.sensor().vehicle_from_rig.translation;
      const auto centroid = visible_head_centroid(renderer.depth(scene, 0), scene.cockpit(), eye);
      ASSERT_TRUE(centroid);
      const Eigen::Vector3d from_centre = *centroid - scene.cockpit().truth.head->centre;
      EXPECT_LT(from_centre.norm(), 0.12);
      EXPECT_GT(from_centre.dot((eye - scene.cockpit().truth.head->centre).normalized()), 0.02);
    }
  }
}

TEST(Sensors, AreInstalledNearlyWhereTheyAreBelievedToBe) {
  for (const CockpitGenerator generator : kBoth) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      for (const CabinSensor& sensor : {structured_light_sensor(generator, seed), stereo_sensor(generator, seed)}) {
        const Rigid3 error = sensor.known_vehicle_from_rig.inverse() * sensor.vehicle_from_rig;
        EXPECT_LT(error.translation.norm(), 0.006);  // 4 standard deviations of 1 mm, in three directions
        EXPECT_LT(angle_between(error, Rigid3{}), 0.4 * M_PI / 180);
      }
    }
  }
}

}  // namespace
}  // namespace raybundle
