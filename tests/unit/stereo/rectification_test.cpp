// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Laws of rectification, for a pair of every two models: rows agree, points come back, tables follow the exact model.
#include "raybundle/stereo/rectification.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/stereo/remap.hpp"
#include "raybundle/stereo/stereo.hpp"

namespace raybundle {
namespace {

// A camera of the model's first example shape, small, so that the tests are fast.
Camera example_camera(ModelId model) {
  return with_model(model, [&]<typename M>() {
    const double focal = 60.0;
    Camera camera = start_camera(model, {160, 120}, focal);
    for (int k = 0; k < kShapeSize<M>; ++k)
      camera.parameters[4 + k] = M::kExamples[0].shape[static_cast<std::size_t>(k)];
    camera.parameters[1] *= 1.01;
    camera.parameters[2] += 1.5;
    return camera;
  });
}

Rigid3 turned(const Eigen::Vector3d& rotation, const Eigen::Vector3d& position) {
  const Rigid3 rig_from_camera{Eigen::Quaterniond(rotation_from_vector(rotation)), position};
  return rig_from_camera.inverse();
}

struct Pair {
  RigCamera left;
  RigCamera right;
};

Pair pair_of(ModelId left, ModelId right) {
  return {{"left", example_camera(left), turned({0.01, 0.03, -0.02}, {0.01, 0.0, 0.0})},
          {"right", example_camera(right), turned({-0.02, -0.01, 0.01}, {0.12, 0.003, -0.004})}};
}

struct EachPairOfModels : testing::TestWithParam<int> {
  Pair pair() const {
    const int models = static_cast<int>(model_names().size());
    return pair_of({GetParam()}, {(GetParam() + 1) % models});
  }
};

TEST_P(EachPairOfModels, PointsLieInTheSameRowAndComeBackFromTheirDisparity) {
  const auto [left, right] = pair();
  const Rectification rectified = rectify(left, right);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> at(-0.4, 0.4);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d x_in_rectified(at(random), at(random), 0.9 + at(random));
    const Eigen::Vector3d x_in_rig = rectified.rig_from_rectified * x_in_rectified;
    const auto u_left =
        rectified.camera.pixel_from_ray(rectified.rectified_from_left * (left.camera_from_rig * x_in_rig));
    const auto u_right =
        rectified.camera.pixel_from_ray(rectified.rectified_from_right * (right.camera_from_rig * x_in_rig));
    ASSERT_TRUE(u_left && u_right);
    EXPECT_NEAR(u_left->y(), u_right->y(), 1e-9);
    const double disparity = u_left->x() - u_right->x();
    EXPECT_GT(disparity, 0.0);
    const double distance = distance_from_disparity(rectified.camera, rectified.baseline_m, u_left->x(), disparity);
    EXPECT_NEAR(disparity_from_distance(rectified.camera, rectified.baseline_m, u_left->x(), distance), disparity,
                1e-9);
    const Eigen::Vector3d ray = *rectified.camera.ray_from_pixel(*u_left);
    const bool pinhole = rectified.camera.projection == RectifiedProjection::kPinhole;
    EXPECT_LT((ray * (pinhole ? distance / ray.z() : distance) - x_in_rectified).norm(), 1e-9);
  }
}

TEST_P(EachPairOfModels, TheWholeFieldIsKeptUnlessItIsLimited) {
  const auto [left, right] = pair();
  const Rectification whole = rectify(left, right);
  // what is lost of lenses beyond 180 degrees lies behind the poles
  EXPECT_GT(whole.kept_left, 0.97);
  EXPECT_GT(whole.kept_right, 0.97);
  const Rectification limited = rectify(left, right, {.field_x_rad = 0.5, .field_y_rad = 0.4});
  EXPECT_LT(limited.kept_left, 0.7);
  EXPECT_NEAR(limited.field_x_rad, 0.5, 2.0 / limited.camera.focal_px);  // sizes are whole pixels
  EXPECT_NEAR(limited.field_y_rad, 0.4, 2.0 / limited.camera.focal_px);
}

TEST_P(EachPairOfModels, TablesFollowTheExactModelTo256thOfAPixel) {
  const auto [left, right] = pair();
  const Rectification rectified = rectify(left, right);
  const RemapTable table = remap_table(left.camera, rectified.camera, rectified.rectified_from_left);
  std::size_t i = 0;
  int covered = 0;
  for (int v = 0; v < table.size.height; ++v) {
    for (int u = 0; u < table.size.width; ++u, ++i) {
      if (!table.covered[i]) continue;
      const auto ray = rectified.camera.ray_from_pixel({u, v});
      const auto exact = pixel_from_ray(left.camera, rectified.rectified_from_left.conjugate() * *ray);
      ASSERT_TRUE(exact);
      ASSERT_LE((Eigen::Vector2d(table.x_256[i], table.y_256[i]) / 256 - *exact).cwiseAbs().maxCoeff(), 1.0 / 256);
      ++covered;
    }
  }
  EXPECT_GT(covered, static_cast<int>(i / 4));
}

INSTANTIATE_TEST_SUITE_P(Models, EachPairOfModels, testing::Range(0, static_cast<int>(model_names().size())),
                         [](const auto& info) {
                           return std::string(model_names()[static_cast<std::size_t>(info.param)]);
                         });

TEST(Remap, AllPathsGiveTheSameBitsAndReadNothingBehindTheImage) {
  const Pair pair = pair_of(*model_named("kannala_brandt"), *model_named("pinhole"));
  const Rectification rectified = rectify(pair.left, pair.right, {.width_px = 203});
  const RemapTable table = remap_table(pair.left.camera, rectified.camera, rectified.rectified_from_left);
  const ImageSize size = pair.left.camera.size;
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(size.width) * size.height);  // no byte more: ASan watches
  std::mt19937 random(1);
  for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(random());
  const GreyView image{pixels.data(), size.width, size.height, size.width};
  std::vector<std::uint8_t> scalar(table.x_256.size()), fast(table.x_256.size(), 7);
  const auto view = [&](std::vector<std::uint8_t>& out) {
    return ImageView<std::uint8_t>{out.data(), table.size.width, table.size.height, table.size.width};
  };
  remap(table, image, view(scalar), Simd::kNone);
  remap(table, image, view(fast), best_simd());
  EXPECT_EQ(scalar, fast);
  for (std::size_t i = 0; i < fast.size(); ++i) {
    if (!table.covered[i]) {
      ASSERT_EQ(fast[i], 0);
      continue;
    }
    const int x = table.x_256[i] >> 8, y = table.y_256[i] >> 8;
    const double fx = (table.x_256[i] & 255) / 256.0, fy = (table.y_256[i] & 255) / 256.0;
    const double exact = (1 - fy) * ((1 - fx) * image.at(x, y) + fx * image.at(x + 1, y)) +
                         fy * ((1 - fx) * image.at(x, y + 1) + fx * image.at(x + 1, y + 1));
    ASSERT_NEAR(fast[i], exact, 0.5001);  // rounded to a grey value
  }
}

TEST(Rectify, ANarrowPairIsAdvisedAPinholeAndAWideOneIsNot) {
  const RigCamera narrow_left{"left", start_camera(*model_named("pinhole"), {640, 480}, 600.0), {}};
  RigCamera narrow_right = narrow_left;
  narrow_right.camera_from_rig.translation.x() = -0.1;
  EXPECT_EQ(rectify(narrow_left, narrow_right).camera.projection, RectifiedProjection::kPinhole);
  RigCamera wide_left = narrow_left;
  wide_left.camera = start_camera(*model_named("kannala_brandt"), {640, 480}, 200.0);
  RigCamera wide_right = wide_left;
  wide_right.camera_from_rig.translation.x() = -0.1;
  EXPECT_EQ(rectify(wide_left, wide_right).camera.projection, RectifiedProjection::kTransverseEquirectangular);
}

// A pair that is rectified already, with its principal point off the middle.
Pair rectified_pair() {
  RigCamera left{"left", start_camera(*model_named("pinhole"), {640, 480}, 600.0), {}};
  left.camera.parameters[2] += 3.25;
  left.camera.parameters[3] -= 7.5;
  RigCamera right = left;
  right.name = "right";
  right.camera_from_rig.translation.x() = -0.1;
  return {left, right};
}

TEST(Rectify, ARectifiedPairRectifiesToItself) {
  const auto [left, right] = rectified_pair();
  const Rectification pair = rectify(left, right);
  EXPECT_EQ(pair.camera.size, left.camera.size);
  EXPECT_NEAR(pair.camera.focal_px, 600.0, 1e-6);  // the derivative that it is taken from is numeric
  EXPECT_NEAR(pair.camera.centre_px.x(), left.camera.cx(), 1e-6);
  EXPECT_NEAR(pair.camera.centre_px.y(), left.camera.cy(), 1e-6);
  EXPECT_EQ(pair.kept_left, 1.0);
  EXPECT_EQ(pair.kept_right, 1.0);
}

TEST(Remap, ImagesOfARectifiedPairStayAsTheyAre) {
  const auto [left, right] = rectified_pair();
  const Rectification pair = rectify(left, right);
  const auto [width, height] = left.camera.size;
  ASSERT_EQ(pair.camera.size, left.camera.size);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * height), out(pixels.size());
  std::mt19937 random(4);
  for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(random());
  const RemapTable table = remap_table(left.camera, pair.camera, pair.rectified_from_left);
  remap(table, {pixels.data(), width, height, width}, {out.data(), width, height, width});
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * width + u;
      ASSERT_TRUE(table.covered[i]) << u << " " << v;
      // the last row and column take 1/256 of the one before
      const int most = v == height - 1 || u == width - 1 ? 2 : 0;
      ASSERT_LE(std::abs(out[i] - pixels[i]), most) << u << " " << v;
    }
  }
}

TEST(Rectify, KeptIsTheShareOfTheImageThatALimitedFieldLeaves) {
  const auto [left, right] = rectified_pair();
  RectifyOptions options;
  options.field_x_rad = 2 * std::atan(160.0 / 600.0);  // half of the columns, and all rows
  options.field_y_rad = 2 * std::atan(247.5 / 600.0);
  const Rectification pair = rectify(left, right, options);
  EXPECT_NEAR(pair.kept_left, 0.5, 1.0 / 97);  // as fine as it is sampled
  EXPECT_NEAR(pair.kept_right, 0.5, 1.0 / 97);
}

// A lens whose image ends within the outermost pixel: what is beyond has no ray, and its field is kept all the same.
TEST(Rectify, ALensWithoutRaysAtTheEdgesKeepsTheFieldOfTheOutermostPixels) {
  RigCamera left{"left", start_camera(*model_named("kannala_brandt"), {160, 120}, 79.8 / 0.8), {}};
  left.camera.parameters[4] = -1 / (3 * 1.2 * 1.2);  // from 1.2 rad on, at 0.8 focal lengths, the radius falls
  ASSERT_FALSE(ray_from_pixel(left.camera, {-0.5, left.camera.cy()}));
  const auto last = ray_from_pixel(left.camera, {0.0, left.camera.cy()});
  ASSERT_TRUE(last);
  RigCamera right = left;
  right.name = "right";
  right.camera_from_rig.translation.x() = -0.1;
  const RectifiedCamera camera = rectify(left, right).camera;
  const auto pixel = camera.pixel_from_ray(*last);
  ASSERT_TRUE(pixel);
  EXPECT_TRUE(camera.contains(*pixel)) << pixel->transpose();
}

TEST(Rectify, QMatrixGivesThePointsOfAPinholePair) {
  const RigCamera left{"left", start_camera(*model_named("pinhole"), {640, 480}, 600.0), {}};
  RigCamera right = left;
  right.camera_from_rig.translation.x() = -0.1;
  const Rectification pair = rectify(left, right);
  const auto q = q_matrix(pair.camera, pair.baseline_m);
  ASSERT_TRUE(q);
  const Eigen::Vector3d x(0.1, -0.2, 1.5);
  const Eigen::Vector2d pixel = *pair.camera.pixel_from_ray(x);
  const double disparity = disparity_from_distance(pair.camera, pair.baseline_m, pixel.x(), x.z());
  const Eigen::Vector4d point = *q * Eigen::Vector4d(pixel.x(), pixel.y(), disparity, 1.0);
  EXPECT_LT((point.hnormalized() - x).norm(), 1e-9);
}

TEST(Rectify, SaysWhatIsWrongWithAPairThatCannotBeRectified) {
  const RigCamera left{"left", start_camera(*model_named("kannala_brandt"), {640, 480}, 200.0), {}};
  RigCamera right = left;
  right.name = "right";
  EXPECT_THROW(rectify(left, right), Error);  // at one place
  right.camera_from_rig.translation = {-0.1, 0, 0};
  try {
    rectify(right, left);
    FAIL() << "swapped";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("--left left --right right"), std::string::npos) << error.what();
  }
  EXPECT_THROW(rectify(left, right, {.projection = RectifiedProjection::kPinhole}), Error);  // too wide for a pinhole
  EXPECT_NO_THROW(
      rectify(left, right, {.projection = RectifiedProjection::kPinhole, .field_x_rad = 1.9, .field_y_rad = 1.5}));
  try {
    rectify(left, right, {.field_x_rad = 300 * M_PI / 180, .field_y_rad = 3.0});
    FAIL() << "beyond the poles";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("300° along the baseline does not exist"), std::string::npos);
  }
  right.camera_from_rig.translation = {0, 0, -0.1};
  EXPECT_THROW(rectify(left, right), Error);  // one behind the other
}

TEST(StereoMatcher, RefusesCamerasThatSeeNothingInCommon) {
  const ModelId fisheye = *model_named("kannala_brandt");
  Calibration calibration;
  calibration.cameras = {{"left", start_camera(fisheye, {640, 480}, 300.0), {}},
                         {"right", start_camera(fisheye, {640, 480}, 650.0), {}}};
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(-100 * M_PI / 180, Eigen::Vector3d::UnitY()));
  const Eigen::Vector3d between(0.1 * std::cos(50 * M_PI / 180), 0.0, -0.1 * std::sin(50 * M_PI / 180));
  calibration.cameras[1].camera_from_rig = {turned, -(turned * between)};
  EXPECT_THROW(StereoMatcher(calibration, "left", "right"), Error);
  calibration.cameras[1].camera_from_rig = {Eigen::Quaterniond::Identity(), {-0.1, 0.0, 0.0}};
  EXPECT_NO_THROW(StereoMatcher(calibration, "left", "right"));
}

}  // namespace
}  // namespace raybundle
