// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/survey.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <random>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

Calibration calibration_of(double k1) {
  Calibration calibration;
  Camera camera{*model_named("kannala_brandt"), {1920, 1200}, Eigen::VectorXd(8)};
  camera.parameters << 700, 700, 960, 600, k1, 0.002, 0, 0;
  calibration.cameras.push_back({"camera", camera, {}});
  return calibration;
}

// A camera that looks north, a little up, at a place of the survey.
Rigid3 camera_from_local() {
  Rigid3 pose;
  pose.rotation =
      Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
  pose.translation = -(pose.rotation * Eigen::Vector3d(1234.0, -4321.0, 12.0));
  return pose;
}

// Towers and hills between 100 m and 6 km away.
std::vector<Landmark> landmarks(int count, double sigma_m) {
  std::mt19937 random(3);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  std::vector<Landmark> result;
  for (int i = 0; i < count; ++i) {
    const double range_m = 100.0 * std::pow(60.0, uniform(0, 1)), azimuth = uniform(-1.1, 1.1);
    const Eigen::Vector3d offset(range_m * std::sin(azimuth), range_m * std::cos(azimuth),
                                 range_m * uniform(-0.1, 0.2));
    result.push_back({"l" + std::to_string(i), Eigen::Vector3d(1234.0, -4321.0, 12.0) + offset, false, sigma_m});
  }
  return result;
}

std::vector<Sighting> sightings(const Calibration& calibration, const std::vector<Landmark>& landmarks, double noise_px,
                                unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Sighting> result;
  for (const Landmark& landmark : landmarks) {
    const Eigen::Vector3d x = landmark.infinitely_far
                                  ? Eigen::Vector3d(camera_from_local().rotation * landmark.x_in_local)
                                  : camera_from_local() * landmark.x_in_local;
    const auto pixel = pixel_from_ray(calibration.cameras[0].camera, x);
    const Eigen::Vector2d noise(noise_px * normal(random), noise_px * normal(random));
    if (pixel) result.push_back({"a.png", landmark.name, *pixel + noise});
  }
  return result;
}

TEST(Survey, ExactSightingsGiveTheExactPose) {
  const Calibration calibration = calibration_of(-0.01);
  const auto surveyed = landmarks(12, 0.05);
  const auto images =
      check_survey(calibration, calibration.cameras[0], {surveyed, sightings(calibration, surveyed, 0.0, 1), 0.5})
          .images;
  ASSERT_EQ(images.size(), 1u);
  EXPECT_LT(angle_between(images[0].camera_from_local, camera_from_local()), 1e-9);
  EXPECT_LT((images[0].camera_from_local.inverse().translation - Eigen::Vector3d(1234, -4321, 12)).norm(), 1e-4);
  EXPECT_LT(images[0].rms_px, 1e-6);
}

TEST(Survey, DirectionsGiveTheRotation) {
  const Calibration calibration = calibration_of(-0.01);
  std::vector<Landmark> stars;
  for (int i = 0; i < 5; ++i) {
    stars.push_back(
        {"s" + std::to_string(i), Eigen::Vector3d(0.3 * i - 0.6, 1.0, 0.1 * (i % 3)).normalized(), true, 1e-5});
  }
  const auto images =
      check_survey(calibration, calibration.cameras[0], {stars, sightings(calibration, stars, 0.0, 1), 0.5}).images;
  EXPECT_LT(images.at(0).camera_from_local.rotation.angularDistance(camera_from_local().rotation), 1e-9);
  EXPECT_TRUE(std::isnan(images[0].pose_sigma[3]));
}

// Over many seeds the mean of chi² per degree of freedom is one: 2 * 12 - 6 of them in each of 100.
TEST(Survey, ResidualsAreAsTheSigmasSay) {
  const Calibration calibration = calibration_of(-0.01);
  const auto surveyed = landmarks(12, 0.0);
  double sum = 0.0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const auto seen = sightings(calibration, surveyed, 0.5, seed);
    sum += check_survey(calibration, calibration.cameras[0], {surveyed, seen, 0.5}).images.at(0).variance_factor;
  }
  EXPECT_NEAR(sum / 100, 1.0, 0.1);  // three standard deviations of that mean
}

TEST(Survey, AMistakenLandmarkIsLeftOutAndAWrongLensIsSeen) {
  const Calibration calibration = calibration_of(-0.01);
  const auto surveyed = landmarks(14, 0.05);
  auto seen = sightings(calibration, surveyed, 0.3, 5);
  seen[4].pixel += Eigen::Vector2d(15, -9);
  const SurveyImage right = check_survey(calibration, calibration.cameras[0], {surveyed, seen, 0.3}).images.at(0);
  EXPECT_FALSE(right.landmarks[4].used);
  EXPECT_EQ(std::ranges::count(right.landmarks, true, &LandmarkResidual::used), std::ssize(seen) - 1);
  EXPECT_LT(right.variance_factor, 2.0);
  const Calibration wrong = calibration_of(-0.03);
  EXPECT_GT(check_survey(wrong, wrong.cameras[0], {surveyed, seen, 0.3}).images.at(0).variance_factor, 4.0);
}

// Wherever one landmark is said to be, the others place the camera as they do without it.
TEST(Survey, NoSingleLandmarkDrawsThePoseAlong) {
  const Calibration calibration = calibration_of(-0.01);
  const auto surveyed = landmarks(14, 0.05);
  const auto seen = sightings(calibration, surveyed, 0.3, 5);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    auto mistaken = surveyed;
    Landmark& landmark = *std::ranges::find(mistaken, seen[i].landmark, &Landmark::name);
    const Eigen::Vector3d centre = camera_from_local().inverse().translation;
    landmark.x_in_local = 2.0 * centre - landmark.x_in_local;  // behind the camera
    const SurveyImage image = check_survey(calibration, calibration.cameras[0], {mistaken, seen, 0.3}).images.at(0);
    EXPECT_EQ(std::ranges::count(image.landmarks, true, &LandmarkResidual::used), std::ssize(seen) - 1) << i;
    EXPECT_LT(image.variance_factor, 2.0) << i;
    EXPECT_LT((image.camera_from_local.inverse().translation - centre).norm(), 0.5) << i;
  }
}

TEST(Survey, AnImageThatCannotBePlacedCostsTheOthersNothing) {
  const Calibration calibration = calibration_of(-0.01);
  const auto surveyed = landmarks(12, 0.05);
  auto seen = sightings(calibration, surveyed, 0.0, 1);
  for (int i = 0; i < 2; ++i) {
    seen.push_back(seen[static_cast<std::size_t>(i)]);
    seen.back().image = "0.png";  // before the other one
  }
  const PlacedImages placed = check_survey(calibration, calibration.cameras[0], {surveyed, seen, 0.5});
  EXPECT_EQ(placed.images.size(), 1u);
  ASSERT_EQ(placed.not_placed.size(), 1u);
  EXPECT_NE(placed.not_placed[0].find("0.png"), std::string::npos);
}

TEST(Survey, TooFewLandmarksPlaceNothing) {
  const Calibration calibration = calibration_of(-0.01);
  const auto surveyed = landmarks(3, 0.0);
  const PlacedImages placed =
      check_survey(calibration, calibration.cameras[0], {surveyed, sightings(calibration, surveyed, 0, 1), 0.5});
  EXPECT_TRUE(placed.images.empty());
  EXPECT_EQ(placed.not_placed.size(), 1u);
}

std::string refusal(const std::vector<Landmark>& surveyed, const std::vector<Sighting>& seen) {
  Calibration calibration = calibration_of(-0.01);
  calibration.cameras[0].camera = {*model_named("pinhole"), {1920, 1200}, Eigen::Vector4d(700, 700, 960, 600)};
  try {
    const PlacedImages placed = check_survey(calibration, calibration.cameras[0], {surveyed, seen, 0.5});
    return placed.not_placed.empty() ? "" : placed.not_placed.front();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Stars from all sides cannot stand in one image: a pose would see none of them where it was clicked.
TEST(Survey, SightingsThatAllDisagreeOrLieOutsideOfTheImageAreRefused) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  const std::vector<Landmark> stars{
      {"a", x, true, 0}, {"b", -x, true, 0}, {"c", y, true, 0}, {"d", -y, true, 0}, {"e", z, true, 0}};
  std::vector<Sighting> seen{{"a.png", "a", {900, 600}},
                             {"a.png", "b", {1000, 600}},
                             {"a.png", "c", {960, 550}},
                             {"a.png", "d", {950, 650}},
                             {"a.png", "e", {970, 610}}};
  EXPECT_THAT(refusal(stars, seen), ::testing::HasSubstr("no place of the camera explains"));
  seen[2].pixel.x() += 3000;
  EXPECT_THAT(refusal(stars, seen), ::testing::HasSubstr("outside of the 1920x1200 image of camera camera"));
}

}  // namespace
}  // namespace raybundle
