// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../runtime/stereo/src/calibration_sigma.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>

#include "raybundle/geometry/rotation.hpp"
#include "raybundle/scene/parameter_names.hpp"

namespace raybundle {
namespace {

RigCamera example(ModelId model, const std::string& name, const Eigen::Vector3d& turn, const Eigen::Vector3d& place) {
  Camera camera = start_camera(model, {160, 120}, 120.0);
  with_model(model, [&]<CameraModel M>() {
    for (int k = 0; k < kShapeSize<M>; ++k) {
      camera.parameters[4 + k] = M::kExamples[0].shape[static_cast<std::size_t>(k)];
    }
  });
  return {name, camera, Rigid3{Eigen::Quaterniond(rotation_from_vector(turn)), place}.inverse()};
}

// Intrinsics, then motion, as their names stand in the covariance.
RigCamera moved(RigCamera camera, Eigen::Index parameter, double step) {
  const Eigen::Index intrinsics = camera.camera.parameters.size();
  if (parameter < intrinsics) {
    camera.camera.parameters[parameter] += step;
  } else {
    const Eigen::Matrix<double, 6, 1> motion = step * Eigen::Matrix<double, 6, 1>::Unit(parameter - intrinsics);
    camera.camera_from_rig = perturbed(camera.camera_from_rig, motion);
  }
  return camera;
}

// The disparity that two pixels seem to have.
double disparity(const Rectification& pair, const RigCamera& left, const RigCamera& right,
                 const Eigen::Vector2d& left_pixel, const Eigen::Vector2d& right_pixel) {
  const auto column = [&](const RigCamera& camera, const Eigen::Vector2d& pixel) {
    const Eigen::Vector3d ray = *ray_from_pixel(camera.camera, pixel);
    return pair.camera
        .pixel_from_ray(pair.rig_from_rectified.rotation.conjugate() *
                        (camera.camera_from_rig.rotation.conjugate() * ray))
        ->x();
  };
  return column(left, left_pixel) - column(right, right_pixel);
}

double baseline(const RigCamera& a, const RigCamera& b) {
  return (a.camera_from_rig.inverse().translation - b.camera_from_rig.inverse().translation).norm();
}

struct EachModel : testing::TestWithParam<int> {};

// Every parameter alone, with small steps of the whole chain.
TEST_P(EachModel, CarriesTheCovarianceAsSmallStepsDo) {
  const ModelId model{GetParam()};
  const RigCamera cameras[] = {example(model, "left", {0.01, 0.03, -0.02}, {0.01, 0.0, 0.0}),
                               example(model, "right", {-0.02, -0.01, 0.01}, {0.12, 0.003, -0.004})};
  const auto& [left, right] = cameras;
  const Rectification pair = rectify(left, right);
  const Eigen::Vector2d middle(0.5 * (pair.camera.size.width - 1), 0.5 * (pair.camera.size.height - 1));
  const Eigen::Vector3d ray = *pair.camera.ray_from_pixel(middle);
  const Eigen::Vector2d left_pixel = *pixel_from_ray(left.camera, pair.rectified_from_left.conjugate() * ray);
  const Eigen::Vector2d right_pixel = *pixel_from_ray(right.camera, pair.rectified_from_right.conjugate() * ray);

  Covariance covariance;
  Eigen::RowVectorXd disparity_by, baseline_by;
  for (const RigCamera& camera : cameras) {
    std::ranges::copy(intrinsic_names(camera), std::back_inserter(covariance.names));
    std::ranges::copy(extrinsic_names(camera), std::back_inserter(covariance.names));
  }
  const Eigen::Index each = left.camera.parameters.size() + 6;
  disparity_by.setZero(2 * each);
  baseline_by.setZero(2 * each);
  for (Eigen::Index i = 0; i < 2 * each; ++i) {
    constexpr double kStep = 1e-6;
    double disparities[2], baselines[2];
    for (int side = 0; side < 2; ++side) {
      const double step = side == 0 ? -kStep : kStep;
      const RigCamera l = i < each ? moved(left, i, step) : left;
      const RigCamera r = i < each ? right : moved(right, i - each, step);
      disparities[side] = disparity(pair, l, r, left_pixel, right_pixel);
      baselines[side] = baseline(l, r);
    }
    disparity_by[i] = (disparities[1] - disparities[0]) / (2.0 * kStep);
    baseline_by[i] = (baselines[1] - baselines[0]) / (2.0 * kStep);
  }
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd root(2 * each, 2 * each);
  for (double& entry : root.reshaped()) entry = 1e-3 * normal(random);
  covariance.matrix = root * root.transpose();

  const CalibrationSigma sigma = calibration_sigma(covariance, left, right, pair);
  const auto expected = [&](const Eigen::RowVectorXd& by) {
    return std::sqrt((by * covariance.matrix * by.transpose()).value());
  };
  EXPECT_NEAR(sigma.relative_baseline * pair.baseline_m / expected(baseline_by), 1.0, 1e-5);
  // The node in the middle of the grid lies in the middle of the image, between pixels where a side is even.
  const auto at = static_cast<std::size_t>(pair.camera.size.height / 2) * pair.camera.size.width +
                  static_cast<std::size_t>(pair.camera.size.width / 2);
  EXPECT_NEAR(sigma.disparity_sigma_px[at] / expected(disparity_by), 1.0, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Models, EachModel, testing::Range(0, static_cast<int>(model_names().size())),
                         [](const auto& info) { return std::string(model_name({info.param})); });

// k1 and k4 of a rational lens take each other's part: however little is known of each, the image is the same.
TEST(CalibrationSigma, IsSmallWhereOnlyTheCoefficientsAreNotKnown) {
  RigCamera left = example(*model_named("rational"), "left", {0, 0, 0}, {0, 0, 0});
  RigCamera right = example(*model_named("rational"), "right", {0, 0, 0}, {0.12, 0, 0});
  for (RigCamera* camera : {&left, &right}) camera->camera.parameters.tail(8).setZero();
  Covariance covariance{{"left.k1", "left.k4", "right.fx"}, Eigen::Matrix3d::Zero()};
  covariance.matrix.topLeftCorner<2, 2>().setConstant(100.0);
  covariance.matrix(2, 2) = 1e-8;
  const CalibrationSigma sigma = calibration_sigma(covariance, left, right, rectify(left, right));
  EXPECT_LT(std::ranges::max(sigma.disparity_sigma_px), 1e-3);
}

}  // namespace
}  // namespace raybundle
