// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// OpenCV as a second opinion on the models that it has. It is linked by this test only.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/ccalib/omnidir.hpp>

#include "oracle_support.hpp"

namespace raybundle {
namespace {

cv::Matx33d camera_matrix(const Camera& camera) {
  return {camera.fx(), 0, camera.cx(), 0, camera.fy(), camera.cy(), 0, 0, 1};
}

std::vector<cv::Point3d> to_opencv(const std::vector<Eigen::Vector3d>& points) {
  std::vector<cv::Point3d> result;
  for (const Eigen::Vector3d& p : points) result.emplace_back(p.x(), p.y(), p.z());
  return result;
}

/// Columns `order` of OpenCV's Jacobian; the three of the translation, at `translation`, are those of the ray.
Opinion opinion(const std::vector<cv::Point2d>& pixels, const cv::Mat& jacobian, int translation,
                const std::vector<int>& order) {
  Opinion result;
  result.pixels.resize(static_cast<Eigen::Index>(pixels.size()), 2);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    result.pixels.row(static_cast<Eigen::Index>(i)) << pixels[i].x, pixels[i].y;
  }
  result.wrt_ray.resize(jacobian.rows, 3);
  result.wrt_parameters.resize(jacobian.rows, static_cast<Eigen::Index>(order.size()));
  for (int row = 0; row < jacobian.rows; ++row) {
    for (int i = 0; i < 3; ++i) result.wrt_ray(row, i) = jacobian.at<double>(row, translation + i);
    for (std::size_t i = 0; i < order.size(); ++i) {
      result.wrt_parameters(row, static_cast<Eigen::Index>(i)) = jacobian.at<double>(row, order[i]);
    }
  }
  return result;
}

template <CameraModel M>
Opinion of_perspective(const Camera& camera, const std::vector<Eigen::Vector3d>& points) {
  const std::vector<double> shape(camera.parameters.data() + 4, camera.parameters.data() + camera.parameters.size());
  std::vector<cv::Point2d> pixels;
  cv::Mat jacobian;
  cv::projectPoints(to_opencv(points), cv::Vec3d(), cv::Vec3d(), camera_matrix(camera), shape, pixels, jacobian);
  std::vector<int> order;  // rotation 0-2, translation 3-5, f 6-7, c 8-9, distortion from 10
  for (int i = 0; i < kParameterCount<M>; ++i) order.push_back(6 + i);
  return opinion(pixels, jacobian, 3, order);
}

template <typename M>
class PerspectiveOracle : public ::testing::Test {};
using PerspectiveModels = ::testing::Types<Pinhole, BrownConrady, Rational, ThinPrism>;
TYPED_TEST_SUITE(PerspectiveOracle, PerspectiveModels, ModelTestName);

TYPED_TEST(PerspectiveOracle, OpenCvProjectPointsAgrees) {
  using M = TypeParam;
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    const auto points = points_up_to(example.half_angle_rad);
    expect_same<M>(camera, points, of_perspective<M>(camera, points));
  }
}

TEST(FisheyeOracle, OpenCvFisheyeAgrees) {
  for (const auto& example : KannalaBrandt::kExamples) {
    const Camera camera = camera_with_shape<KannalaBrandt>(example.shape.data());
    const auto points = points_up_to(std::min(1.4, example.half_angle_rad));  // cv::fisheye divides by z
    std::vector<cv::Point2d> pixels;
    cv::Mat jacobian;
    cv::fisheye::projectPoints(to_opencv(points), pixels, cv::Vec3d(), cv::Vec3d(), camera_matrix(camera),
                               cv::Vec4d(camera.parameters.data() + 4), 0, jacobian);
    // f 0-1, c 2-3, k 4-7, rotation 8-10, translation 11-13, skew 14
    expect_same<KannalaBrandt>(camera, points, opinion(pixels, jacobian, 11, {0, 1, 2, 3, 4, 5, 6, 7}));
  }
}

TEST(OmnidirectionalOracle, OpenCvOmnidirAgrees) {
  for (const auto& example : Unified::kExamples) {
    const Camera camera = camera_with_shape<Unified>(example.shape.data());
    const auto points = points_up_to(example.half_angle_rad);
    std::vector<cv::Point2d> pixels;
    cv::Mat jacobian;
    cv::omnidir::projectPoints(to_opencv(points), pixels, cv::Vec3d(), cv::Vec3d(), camera_matrix(camera),
                               camera.parameters[4], cv::Vec4d(camera.parameters.data() + 5), jacobian);
    // rotation 0-2, translation 3-5, f 6-7, skew 8, c 9-10, xi 11, distortion 12-15
    expect_same<Unified>(camera, points, opinion(pixels, jacobian, 3, {6, 7, 9, 10, 11, 12, 13, 14, 15}));
  }
}

}  // namespace
}  // namespace raybundle
