// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/render.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <thread>

#include "raybundle/targets/detect.hpp"

namespace raybundle::testing {
namespace {

constexpr double kRadian = std::numbers::pi / 180;

Camera small_camera(const char* model, double focal_px) {
  Camera camera = start_camera(*model_named(model), {200, 160}, focal_px);
  camera.parameters[2] += 1.37;
  camera.parameters[3] -= 0.81;
  return camera;
}

// A chessboard in front of one camera of 12 bits.
SimulatedRig board_rig(const Camera& camera) {
  SimulatedRig rig;
  SimulatedCamera seen;
  seen.name = "camera";
  seen.camera = camera;
  seen.sensor.bits = 12;
  rig.cameras.push_back(seen);
  rig.board = simulated_chessboard(7, 5, 0.03);
  rig.board.print.sheet.low.array() -= 0.03;
  rig.board.print.sheet.high.array() += 0.03;
  return rig;
}

// Board centre at a place, tilted and rolled.
Rigid3 pose_at(const Eigen::Vector3d& place, const Eigen::Vector3d& turned_deg) {
  Rigid3 pose;
  pose.rotation = Eigen::AngleAxisd(turned_deg.z() * kRadian, Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(turned_deg.y() * kRadian, Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(turned_deg.x() * kRadian, Eigen::Vector3d::UnitX());
  pose.translation = place - pose.rotation * Eigen::Vector3d(0.09, 0.06, 0);
  return pose;
}

cv::Mat grey_16(const GreyImage& image) {
  cv::Mat mat(image.size.height, image.size.width, CV_16U);
  const int to_16_bits = 1 << (16 - image.bits);
  for (int y = 0; y < mat.rows; ++y) {
    for (int x = 0; x < mat.cols; ++x) {
      mat.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(image.at(x, y) * to_16_bits);
    }
  }
  return mat;
}

struct CornerErrors {
  int count = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double rms_px = 0, worst_px = 0;
};

// The project's own refinement on images without noise, against the projected corners.
CornerErrors corner_errors(const SimulatedRig& rig, const std::vector<Rigid3>& poses) {
  const ViewRenderer renderer(rig);
  CornerErrors errors;
  for (const Rigid3& pose : poses) {
    const RenderedView view = renderer.render(0, pose, {.noise = false});
    const auto found = refine_predicted(Chessboard{7, 5, 0.03}, grey_16(view.off), view.corners);
    for (const Observation& corner : found) {
      for (const Observation& truth : view.corners) {
        if (truth.point_id != corner.point_id) continue;
        const Eigen::Vector2d error = corner.pixel - truth.pixel;
        errors.mean += error;
        errors.rms_px += error.squaredNorm();
        errors.worst_px = std::max(errors.worst_px, error.norm());
        ++errors.count;
      }
    }
  }
  errors.mean /= errors.count;
  errors.rms_px = std::sqrt(errors.rms_px / errors.count);
  return errors;
}

// What remains is the refinement's own error on curved saddles, which a shift of the image would add to.
TEST(Render, CornersAreWhereAPinholeProjectsThem) {
  SimulatedRig rig = board_rig(small_camera("pinhole", 170));
  rig.board.shape = {0.003, -0.002, 0.001};
  const CornerErrors errors =
      corner_errors(rig, {pose_at({0.01, 0, 0.3}, {10, 5, 3}), pose_at({-0.01, 0.01, 0.32}, {-30, 20, 40}),
                          pose_at({0, 0, 0.28}, {0, 0, 0}), pose_at({0.02, -0.01, 0.3}, {25, -25, 12})});
  EXPECT_GE(errors.count, 130);
  EXPECT_LT(errors.mean.norm(), 0.01);
  EXPECT_LT(errors.rms_px, 0.02);
}

TEST(Render, CornersAreWhereAFisheyeProjectsThem) {
  Camera camera = small_camera("kannala_brandt", 58);  // 190 degrees across
  camera.size = {220, 220};
  camera.parameters[2] = 109.2;
  camera.parameters[3] = 110.7;
  const SimulatedRig rig = board_rig(camera);
  const CornerErrors errors =
      corner_errors(rig, {pose_at({0.01, 0, 0.11}, {10, 5, 3}), pose_at({-0.12, 0.03, 0.05}, {-10, -50, 20}),
                          pose_at({0.1, -0.06, 0.04}, {20, 60, 0}), pose_at({0.0, 0.11, 0.05}, {-60, 0, 35})});
  EXPECT_GE(errors.count, 100);
  EXPECT_LT(errors.mean.norm(), 0.02);
}

// One beam straight ahead onto a white board.
SimulatedRig spot_rig(double focal_px) {
  SimulatedRig rig = board_rig(small_camera("pinhole", focal_px));
  rig.board.print.boxes.clear();
  Emitter emitter;
  emitter.grid = {3, 3};
  emitter.column_period_m = emitter.row_period_m = 8e-6;
  emitter.zero_order_row = emitter.zero_order_column = 1;
  emitter.rig_from_emitter.translation = {0.06, 0.013, 0};
  rig.emitter = emitter;
  return rig;
}

// Centroid of on minus off within some pixels of a dot.
Eigen::Vector2d centroid(const RenderedView& view, const Eigen::Vector2d& near) {
  constexpr int kReach = 8;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0;
  const Eigen::Vector2i at = near.array().round().cast<int>();
  for (int y = at.y() - kReach; y <= at.y() + kReach; ++y) {
    for (int x = at.x() - kReach; x <= at.x() + kReach; ++x) {
      const double light = view.on.at(x, y) - view.off.at(x, y);
      sum += light * Eigen::Vector2d(x, y);
      weight += light;
    }
  }
  return sum / weight;
}

TEST(Render, SpotsAreCentredWhereBeamsMeetTheBoard) {
  SimulatedRig rig = spot_rig(170);
  rig.light.ambient_W_m2 = 0.5;
  rig.cameras[0].sensor.exposure = 0.5;
  const ViewRenderer renderer(rig);
  int checked = 0;
  for (const Eigen::Vector3d& turned_deg :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(30, 0, 10), Eigen::Vector3d(-20, 35, 0)}) {
    const RenderedView view =
        renderer.render(0, pose_at({0.06, 0.01, 0.4}, turned_deg), {.noise = false, .speckle = false});
    for (const RenderedDot& dot : view.dots) {
      const Eigen::Vector2d error = centroid(view, dot.pixel) - dot.pixel;
      if (!dot.on_board) continue;
      EXPECT_LT(error.norm(), 0.02);
      ++checked;
    }
  }
  EXPECT_GE(checked, 15);
}

}  // namespace
}  // namespace raybundle::testing
