// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The file of `export --rectification`, as a user of OpenCV reads it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>  // before OpenCV's header for it
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>

#include "program.hpp"
#include "raybundle/io/calibration_file.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

const Rigid3 kLeftFromRig{Eigen::Quaterniond(Eigen::AngleAxisd(0.04, Eigen::Vector3d(1, 2, 3).normalized())),
                          Eigen::Vector3d(0.02, -0.01, 0.03)};
const Rigid3 kRightFromLeft{Eigen::Quaterniond(Eigen::AngleAxisd(-0.05, Eigen::Vector3d(3, 1, -2).normalized())),
                            Eigen::Vector3d(-0.12, 0.004, -0.006)};

// Two unlike lenses, turned against each other, on a rig whose frame is that of neither.
Calibration turned_pair() {
  Calibration calibration;
  calibration.cameras = {
      {"left", start_camera(*model_named("brown_conrady"), {640, 480}, 500.0), kLeftFromRig},
      {"right", start_camera(*model_named("kannala_brandt"), {640, 480}, 450.0), kRightFromLeft * kLeftFromRig}};
  calibration.cameras[0].camera.parameters.tail<5>() << -0.05, 0.02, -0.001, 0.0005, 0.004;
  calibration.cameras[1].camera.parameters.tail<4>() << -0.02, 0.005, -0.003, 0.0004;
  return calibration;
}

// A camera's part of the file.
struct RectifiedView {
  Eigen::MatrixXd rotation, projection;
  cv::Mat map_x, map_y;

  RectifiedView(const cv::FileStorage& file, const std::string& side, int number) {
    for (const auto& [key, matrix] : {std::pair("R", &rotation), std::pair("P", &projection)}) {
      cv::cv2eigen(file[key + std::to_string(number)].mat(), *matrix);
    }
    map_x = file[side + "_map_x"].mat();
    map_y = file[side + "_map_y"].mat();
  }

  /// The rectified pixel of a point in the left rectified camera's frame, as cv::stereoRectify says.
  Eigen::Vector2d pixel_of(const Eigen::Vector3d& x_in_rectified) const {
    return Eigen::Vector3d(projection * x_in_rectified.homogeneous()).hnormalized();
  }

  /// The map leads where the camera sees the ray of the nearest whole pixel.
  void expect_map_follows(const Camera& camera, const Eigen::Vector2d& pixel) const {
    constexpr double kStep_px = 1.0 / 512 + 1e-9;  // half of the 1/256 px that maps are rounded to, and rounding
    const auto u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
    ASSERT_TRUE(cv::Rect(0, 0, map_x.cols, map_x.rows).contains({u, v}));
    const Eigen::Matrix3d matrix = projection.leftCols(3);
    const auto source = pixel_from_ray(camera, rotation.transpose() * (matrix.inverse() * Eigen::Vector3d(u, v, 1)));
    ASSERT_TRUE(source);
    EXPECT_NEAR(map_x.at<float>(v, u), source->x(), kStep_px);
    EXPECT_NEAR(map_y.at<float>(v, u), source->y(), kStep_px);
  }
};

TEST(RectificationExport, IsWhatStereoRectifyCallsByTheseNames) {
  const fs::path folder = fresh_folder();
  CalibrationFile file;
  file.calibration = turned_pair();
  write_calibration(folder / "pair.json", file);
  const ProgramRun run = raybundle_program({"export", (folder / "pair.json").string(), "--rectification",
                                            folder.string(), "--projection", "pinhole", "--width", "200"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const cv::FileStorage read((folder / "rectification.yml").string(), cv::FileStorage::READ);
  const RectifiedView left(read, "left", 1), right(read, "right", 2);
  Eigen::Matrix4d point_from_disparity;
  cv::cv2eigen(read["Q"].mat(), point_from_disparity);

  const double focal_px = left.projection(0, 0), baseline_m = kRightFromLeft.translation.norm();
  constexpr double kRounding = 1e-9;  // [px, m]: of some hundreds, in doubles
  EXPECT_EQ(left.projection.col(3), Eigen::Vector3d::Zero());
  EXPECT_NEAR(right.projection(0, 3), -focal_px * baseline_m, kRounding);
  for (const double x : {-0.15, 0.02, 0.3}) {
    for (const double y : {-0.2, 0.13}) {
      SCOPED_TRACE(fmt::format("at {}, {}", x, y));
      const Eigen::Vector3d x_in_left(x, y, 1.1 - x + y), x_in_rectified = left.rotation * x_in_left;
      const Eigen::Vector2d in_left = left.pixel_of(x_in_rectified), in_right = right.pixel_of(x_in_rectified);
      EXPECT_NEAR(in_left.y(), in_right.y(), kRounding);
      // The right camera sees it there too, from where it stands.
      const Eigen::Vector3d x_in_right = right.rotation * (kRightFromLeft * x_in_left);
      EXPECT_LT((left.pixel_of(x_in_right) - in_right).norm(), kRounding);
      const Eigen::Vector4d back =
          point_from_disparity * Eigen::Vector4d(in_left.x(), in_left.y(), in_left.x() - in_right.x(), 1.0);
      EXPECT_LT((back.hnormalized() - x_in_rectified).norm(), kRounding);
      left.expect_map_follows(file.calibration.cameras[0].camera, in_left);
      right.expect_map_follows(file.calibration.cameras[1].camera, in_right);
    }
  }
}

}  // namespace
}  // namespace raybundle::testing
