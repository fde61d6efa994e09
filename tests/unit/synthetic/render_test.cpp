// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "raybundle/scene/board_surface.hpp"
#include "raybundle/targets/detect.hpp"
#include "render_rigs.hpp"

namespace raybundle::testing {
namespace {

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

// Ambient light on the board around a pixel, in the square of the pixel blurred by the lens.
double integrated_light(const SimulatedRig& rig, const Camera& camera, const Rigid3& pose,
                        const Eigen::Vector2d& pixel) {
  constexpr int kSamples = 48;  // per pixel, each way
  const double sigma = rig.cameras[0].sensor.lens_blur_px;
  const BoardSurface surface(rig.board.target);
  const auto weight = [&](double away) {
    return 0.5 * (std::erf((away + 0.5) / sigma * M_SQRT1_2) - std::erf((away - 0.5) / sigma * M_SQRT1_2));
  };
  const Rigid3 target_from_camera = pose.inverse();
  const int reach = 4 * kSamples;
  double sum = 0, weights = 0;
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const Eigen::Vector2d away = Eigen::Vector2d(i + 0.31, j - 0.17) / kSamples;
      const double w = weight(away.x()) * weight(away.y());
      const Eigen::Vector3d ray = *ray_from_pixel(camera, pixel + away);
      const auto place =
          *surface.crossing({target_from_camera.translation, target_from_camera.rotation * ray}, rig.board.shape);
      const auto in_box = [&](const BoardPrint::Box& box) {
        return (place.head<2>().array() > box.low.array()).all() && (place.head<2>().array() < box.high.array()).all();
      };
      const bool ink = std::ranges::any_of(rig.board.print.boxes, in_box);
      sum += w * (ink ? rig.board.ink_albedo : rig.board.paper_albedo);
      weights += w;
    }
  }
  return rig.light.ambient_W_m2 * sum / weights;
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

// The rim of a lens of 190 degrees, out of an image that is too large to be rendered in a test.
SimulatedCamera rim_camera() {
  SimulatedCamera rim = board_rig(small_camera("kannala_brandt", 400)).cameras[0];
  rim.camera.size = {300, 300};
  rim.camera.parameters[2] = -369.3;
  rim.camera.parameters[3] = 150.4;
  return rim;
}

// Board at so many degrees off the axis, turned against the line of sight.
Rigid3 pose_at_rim(double angle_deg, const Eigen::Vector3d& turned_deg) {
  const double angle = angle_deg * kRadian;
  Rigid3 pose = pose_at({0, 0, 0.45}, turned_deg);
  const Eigen::AngleAxisd aside(angle, Eigen::Vector3d::UnitY());
  return {(aside * pose.rotation).normalized(), aside * pose.translation};
}

TEST(Render, CornersAreWhereAFisheyeProjectsThem) {
  SimulatedRig rig = board_rig(rim_camera().camera);
  rig.board.shape = {0.002, -0.003, 0.001};
  const CornerErrors errors =
      corner_errors(rig, {pose_at_rim(72, {0, 0, 0}), pose_at_rim(78, {20, -15, 30}), pose_at_rim(76, {-25, 10, -40})});
  EXPECT_GE(errors.count, 90);
  EXPECT_LT(errors.mean.norm(), 0.01);
  EXPECT_LT(errors.rms_px, 0.02);
}

TEST(Render, EveryCameraModelSeesTheBoard) {
  Models::for_each([]<CameraModel M>() {
    Camera camera = small_camera(std::string(M::kName).c_str(), 150);
    for (int k = 0; k < kShapeSize<M>; ++k) camera.parameters[4 + k] = M::kExamples[0].shape[k];
    const Eigen::Vector2d middle = *pixel_from_ray(camera, {0.01, 0, 0.3});
    camera.parameters.segment<2>(2) += Eigen::Vector2d(99.3, 78.6) - middle;
    const CornerErrors errors = corner_errors(board_rig(camera), {pose_at({0.01, 0, 0.3}, {20, -10, 25})});
    EXPECT_GE(errors.count, 30) << M::kName;
    EXPECT_LT(errors.mean.norm(), 0.01) << M::kName;
    EXPECT_LT(errors.rms_px, 0.03) << M::kName;
  });
}

// Grey values against sums over 150,000 samples of the exact rays, without anything that the renderer uses: 6 of 4095
// grey values are an edge that is 0.008 px away, as where the blur is steep within a cell.
TEST(Render, PixelsAreIntegralsOfTheLight) {
  SimulatedRig rig = board_rig(rim_camera().camera);
  rig.cameras[0].sensor.vignetting = 0;
  rig.cameras[0].sensor.exposure = 2;
  rig.board.shape = {0.004, 0.003, 0.002};
  const Rigid3 pose = pose_at_rim(80, {20, 25, 30});
  const RenderedView view = render_view(rig, 0, pose, {.noise = false});
  const Camera& camera = rig.cameras[0].camera;
  for (const std::size_t corner : {3u, 17u, 30u}) {
    for (const int aside : {0, 2}) {
      const Eigen::Vector2i at = view.corners[corner].pixel.array().round().cast<int>() + Eigen::Array2i(aside, 1);
      const double expected = 4095 * (0.03 + 2 * integrated_light(rig, camera, pose, at.cast<double>()) / 8);
      EXPECT_NEAR(view.off.at(at.x(), at.y()), expected, 6.0);
    }
  }
}

}  // namespace
}  // namespace raybundle::testing
