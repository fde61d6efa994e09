// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "laser_world.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "synthetic_world.hpp"

namespace raybundle {
namespace {

using testing::synthetic_world;
using testing::SyntheticOptions;
using testing::SyntheticWorld;

struct Scenery {
  bool infinitely_far = false;
  double noise_px = 0.0;
  double landmark_sigma = 0.0;  // [m] or [rad]
  unsigned seed = 1;
};

// The rig looks north from somewhere 5 km off the survey's origin, in two moments, a little turned in between.
std::vector<Rigid3> rig_poses() {
  std::vector<Rigid3> poses;
  for (const double turn : {-0.2, 0.3}) {
    Rigid3 rig_from_local;
    rig_from_local.rotation =
        Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
    rig_from_local.translation = -(rig_from_local.rotation * Eigen::Vector3d(1200.0 + 50 * turn, -4900.0, 15.0));
    poses.push_back(rig_from_local);
  }
  return poses;
}

// Landmarks 20 m to 2 km around the rig, seen by all of its cameras.
Survey survey_of(const SyntheticWorld& world, const Scenery& scenery) {
  std::mt19937 random(scenery.seed);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  std::normal_distribution<double> normal;
  Survey survey{{}, {}, std::max(scenery.noise_px, 0.01)};
  std::vector<Eigen::Vector3d> truth;
  for (int i = 0; i < 24; ++i) {
    const double azimuth = uniform(-1.2, 1.2), range_m = 20.0 * std::pow(100.0, uniform(0, 1));
    const Eigen::Vector3d offset(std::sin(azimuth), std::cos(azimuth), uniform(-0.5, 0.6));
    truth.push_back(scenery.infinitely_far ? Eigen::Vector3d(offset.normalized())
                                           : Eigen::Vector3d(Eigen::Vector3d(1200, -4900, 15) + range_m * offset));
    const Eigen::Vector3d error =
        scenery.landmark_sigma * Eigen::Vector3d(normal(random), normal(random), normal(random));
    survey.landmarks.push_back(
        {"mark" + std::to_string(i), truth.back() + error, scenery.infinitely_far, scenery.landmark_sigma});
  }
  const std::vector<Rigid3> poses = rig_poses();
  for (std::size_t p = 0; p < poses.size(); ++p) {
    for (std::size_t c = 0; c < world.cameras.size(); ++c) {
      const Rigid3 camera_from_local = world.camera_from_rig[c] * poses[p];
      for (std::size_t i = 0; i < truth.size(); ++i) {
        const Eigen::Vector3d x = scenery.infinitely_far ? Eigen::Vector3d(camera_from_local.rotation * truth[i])
                                                         : camera_from_local * truth[i];
        const auto pixel = pixel_from_ray(world.cameras[c], x);
        const ImageSize size = world.cameras[c].size;
        if (!pixel || pixel->minCoeff() < 0 || pixel->x() > size.width - 1 || pixel->y() > size.height - 1) continue;
        const Eigen::Vector2d noise = scenery.noise_px * Eigen::Vector2d(normal(random), normal(random));
        survey.sightings.push_back(
            {"moment" + std::to_string(p), survey.landmarks[i].name, *pixel + noise, world.problem.cameras[c].name});
      }
    }
  }
  return survey;
}

// Boards in a narrow field about the axis, so that the landmarks have something to add.
SyntheticOptions narrow_boards(double noise_px, unsigned seed) {
  SyntheticOptions options;
  options.frames = 12;
  options.noise_px = noise_px;
  options.seed = seed;
  options.max_off_axis_rad = 0.6;
  return options;
}

SyntheticOptions stereo(double noise_px, unsigned seed) {
  SyntheticOptions options = narrow_boards(noise_px, seed);
  options.cameras.resize(2);
  options.cameras[1].camera_from_rig.translation = {-0.12, 0.0, 0.0};
  return options;
}

double largest_error(const CalibrationResult& result, const SyntheticWorld& world) {
  double largest = 0.0;
  for (std::size_t c = 0; c < world.cameras.size(); ++c) {
    const RigCamera& camera = result.calibration.cameras[c];
    largest = std::max(largest, (camera.camera.parameters - world.cameras[c].parameters)
                                    .cwiseQuotient(world.cameras[c].parameters.cwiseAbs().cwiseMax(1.0))
                                    .cwiseAbs()
                                    .maxCoeff());
    largest = std::max(largest, motion_between(world.camera_from_rig[c], camera.camera_from_rig).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(SurveyInTheBundle, ExactPointsLeaveTheTruth) {
  SyntheticWorld world = synthetic_world(stereo(0.0, 1));
  world.problem.survey = survey_of(world, {});
  const CalibrationResult result = calibrate(world.problem);
  EXPECT_LT(largest_error(result, world), 1e-8);
  ASSERT_TRUE(result.survey.has_value());
  ASSERT_EQ(result.survey->images.size(), 4u);  // two moments, two cameras
  for (const SurveyImage& image : result.survey->images) {
    EXPECT_LT(image.rms_px, 1e-6) << image.image << image.camera;
    const Rigid3 truth =
        world.camera_from_rig[image.camera == world.problem.cameras[1].name] * rig_poses()[image.image == "moment1"];
    EXPECT_LT((image.camera_from_local.inverse().translation - truth.inverse().translation).norm(), 1e-6);  // at 5 km
  }
  EXPECT_EQ(result.views.size(), world.problem.views.size());
  EXPECT_EQ(result.calibration.targets.size(), world.problem.targets.size());
}

TEST(SurveyInTheBundle, ExactDirectionsLeaveTheTruth) {
  SyntheticWorld world = synthetic_world(stereo(0.0, 1));
  world.problem.survey = survey_of(world, {.infinitely_far = true});
  const CalibrationResult result = calibrate(world.problem);
  EXPECT_LT(largest_error(result, world), 1e-8);
  EXPECT_EQ(result.survey->images.size(), 4u);
  EXPECT_LT(result.survey->images[0].rms_px, 1e-6);
}

TEST(SurveyInTheBundle, FarLandmarksTellTheLensWhereNoBoardWas) {
  SyntheticWorld world = synthetic_world(stereo(0.2, 3));
  const Covariance without = calibrate(world.problem).calibration.covariance;
  world.problem.survey = survey_of(world, {.infinitely_far = true, .noise_px = 0.2});
  const Covariance with = calibrate(world.problem).calibration.covariance;
  const std::string right = world.problem.cameras[1].name;
  EXPECT_LT(with.sigma(right + ".k4"), 0.2 * without.sigma(right + ".k4"));
  EXPECT_LT(with.sigma(right + ".camera_from_rig.rotation_y"), without.sigma(right + ".camera_from_rig.rotation_y"));
  for (const std::string& any : without.names) EXPECT_LT(with.sigma(any), 1.1 * without.sigma(any)) << any;
}

// Squared errors, whitened by the covariance, have the mean of their number when noise of corners, clicks and landmarks
// is as stated. The tolerance is four standard deviations of the mean of 24 draws of chi² with 8 degrees of freedom.
class SurveyCovariance : public ::testing::TestWithParam<bool> {};

TEST_P(SurveyCovariance, IsThatOfTheScatter) {
  constexpr int kSeeds = 24;
  double sum = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    SyntheticWorld world = synthetic_world(narrow_boards(0.2, seed));
    const double sigma = GetParam() ? 3e-4 : 0.03;
    world.problem.survey =
        survey_of(world, {.infinitely_far = GetParam(), .noise_px = 0.4, .landmark_sigma = sigma, .seed = seed});
    const CalibrationResult result = calibrate(world.problem, {.estimate_shape = false});
    ASSERT_TRUE(result.survey.has_value()) << (result.warnings.empty() ? "" : result.warnings.back());
    const Eigen::VectorXd error = result.calibration.cameras[0].camera.parameters - world.cameras[0].parameters;
    sum += error.dot(result.calibration.covariance.matrix.ldlt().solve(error));
    count = static_cast<int>(error.size());
  }
  const double mean = sum / kSeeds;
  EXPECT_NEAR(mean, count, 4.0 * std::sqrt(2.0 * count / kSeeds));
}

INSTANTIATE_TEST_SUITE_P(Landmarks, SurveyCovariance, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? std::string("far") : std::string("near"); });

TEST(SurveyInTheBundle, AWrongSightingAndAnImageThatCannotBePlacedCostNothing) {
  SyntheticWorld world = synthetic_world(narrow_boards(0.2, 5));
  Survey survey = survey_of(world, {.noise_px = 0.3});
  survey.sightings[3].pixel += Eigen::Vector2d(25, -14);
  for (int i = 0; i < 3; ++i) {
    Sighting alone = survey.sightings[static_cast<std::size_t>(i)];
    alone.image = "three of them";
    survey.sightings.push_back(alone);
  }
  world.problem.survey = survey;
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_EQ(result.survey->images.size(), 2u);
  const auto& landmarks = result.survey->images[0].landmarks;
  const auto wrong = std::ranges::find(landmarks, survey.sightings[3].landmark, &LandmarkResidual::landmark);
  EXPECT_FALSE(wrong->used);
  EXPECT_NEAR(wrong->residual_px.x(), 25.0, 3.0);
  EXPECT_EQ(std::ranges::count(landmarks, false, &LandmarkResidual::used), 1);
  EXPECT_TRUE(std::ranges::any_of(result.warnings,
                                  [](const std::string& w) { return w.find("three of them") != std::string::npos; }));
  EXPECT_LT(drag_sigmas(result.survey->parameters), 4.0);
}

// The polynomials of a lens go on behind the camera, and one landmark there would bend it.
TEST(SurveyInTheBundle, ALandmarkBehindTheCameraDoesNotBendTheLens) {
  SyntheticWorld world = synthetic_world(narrow_boards(0.2, 5));
  Survey survey = survey_of(world, {.noise_px = 0.3});
  world.problem.survey = survey;
  const Camera without = calibrate(world.problem).calibration.cameras[0].camera;
  for (const std::size_t i : {0u, 3u, 6u}) {
    world.problem.survey = survey;
    Landmark& landmark =
        *std::ranges::find(world.problem.survey->landmarks, survey.sightings[i].landmark, &Landmark::name);
    landmark.x_in_local = 2.0 * Eigen::Vector3d(1200, -4900, 15) - landmark.x_in_local;
    const CalibrationResult result = calibrate(world.problem);
    for (const LandmarkResidual& seen : result.survey->images.at(0).landmarks) {
      EXPECT_EQ(seen.used, seen.landmark != landmark.name) << seen.landmark;
    }
    const double sigma = result.calibration.covariance.sigma(world.problem.cameras[0].name + ".k4");
    EXPECT_NEAR(result.calibration.cameras[0].camera.parameters[7], without.parameters[7], 2.0 * sigma) << i;
  }
}

// The camera that knows where the rig is starts it, although the other one sees more.
TEST(SurveyInTheBundle, StarsOfOneCameraAndTowersOfTheOther) {
  SyntheticWorld world = synthetic_world(stereo(0.0, 1));
  Survey survey = survey_of(world, {});
  const Survey stars = survey_of(world, {.infinitely_far = true, .seed = 2});
  const std::string left = world.problem.cameras[0].name;
  std::erase_if(survey.sightings, [&](const Sighting& s) { return s.camera == left || s.landmark.size() > 5; });
  for (Landmark landmark : stars.landmarks) {
    landmark.name = "star" + landmark.name;
    survey.landmarks.push_back(landmark);
  }
  for (Sighting sighting : stars.sightings) {
    sighting.landmark = "star" + sighting.landmark;
    if (sighting.camera == left) survey.sightings.push_back(sighting);
  }
  world.problem.survey = survey;
  const CalibrationResult result = calibrate(world.problem);
  EXPECT_LT(largest_error(result, world), 1e-8);
  ASSERT_EQ(result.survey->images.size(), 4u);
  for (const SurveyImage& image : result.survey->images) {
    EXPECT_LT(image.rms_px, 1e-6) << image.image << image.camera;
    EXPECT_EQ(std::ranges::count(image.landmarks, false, &LandmarkResidual::used), 0) << image.image << image.camera;
  }
}

// Landmarks are no board: beams are found beside them.
TEST(SurveyInTheBundle, BeamsAreFoundBesideLandmarks) {
  SyntheticWorld world = synthetic_world(testing::laser_rig_options(30, 4));
  const testing::LaserTruth truth = testing::add_laser(world, {.noise_px = 0, .brightest_factor = 2.0, .seed = 4});
  world.problem.laser->brightest = 60;
  world.problem.survey = survey_of(world, {});
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_TRUE(result.survey && result.calibration.laser);
  EXPECT_EQ(result.survey->images.size(), 2u);
  EXPECT_LT(largest_error(result, world), 1e-7);
  const LaserPattern& pattern = *result.calibration.laser;
  EXPECT_GT(pattern.beams.size(), 110u);
  for (const LaserBeam& beam : pattern.beams) {
    const Line3& line = *truth.lines[pattern.grid.index(beam.row, beam.column)];
    EXPECT_LT(motion_between(beam.line, line).head<2>().norm(), 1e-6);
  }
}

TEST(SurveyInTheBundle, ARepeatedSightingIsRefused) {
  SyntheticWorld world = synthetic_world(narrow_boards(0.2, 5));
  Survey survey = survey_of(world, {});
  survey.sightings.push_back(survey.sightings[0]);
  survey.sightings.back().camera.clear();  // there is only one
  world.problem.survey = survey;
  EXPECT_THROW(calibrate(world.problem), Error);
}

// Landmarks of another focal length than that of the boards, by many of its sigmas.
TEST(SurveyInTheBundle, ASurveyThatContradictsTheBoardsIsTold) {
  for (const double stretch : {0.0, 0.003}) {
    SyntheticWorld world = synthetic_world(narrow_boards(0.05, 5));
    Survey survey = survey_of(world, {.infinitely_far = true, .noise_px = 0.05});
    for (Sighting& sighting : survey.sightings) {
      sighting.pixel += stretch * (sighting.pixel - Eigen::Vector2d(640, 480));
    }
    world.problem.survey = survey;
    const CalibrationResult result = calibrate(world.problem);
    EXPECT_EQ(result.survey->images.size(), 2u);
    const auto told = [&](const char* what) {
      return std::ranges::any_of(result.warnings, [&](const auto& w) { return w.find(what) != std::string::npos; });
    };
    EXPECT_EQ(told("the landmarks drag the cameras: camera0."), stretch > 0.0);
    EXPECT_EQ(told("landmarks"), stretch > 0.0);
  }
}

}  // namespace
}  // namespace raybundle
