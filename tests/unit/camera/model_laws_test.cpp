// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <set>

#include "law_support.hpp"

namespace raybundle {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

template <typename M>
class ModelLaws : public ::testing::Test {};
TYPED_TEST_SUITE(ModelLaws, AsTestTypes<Models>::Type, ModelTestName);

TYPED_TEST(ModelLaws, NamesAreUniqueAndKnown) {
  using M = TypeParam;
  const std::optional<ModelId> id = model_named(M::kName);
  ASSERT_TRUE(id.has_value());
  EXPECT_EQ(model_name(*id), M::kName);
  const std::vector<std::string_view> names = parameter_names(*id);
  EXPECT_EQ(std::set<std::string_view>(names.begin(), names.end()).size(), names.size());
  EXPECT_FALSE(M::kForeignNames.empty());
}

TYPED_TEST(ModelLaws, RayToPlaneToRay) {
  using M = TypeParam;
  for (const auto& example : M::kExamples) {
    for (const Vector3d& ray : rays_up_to(example.half_angle_rad)) {
      Vector2d plane;
      Vector3d again;
      ASSERT_TRUE(M::plane_from_ray(example.shape.data(), ray.data(), plane.data())) << ray.transpose();
      ASSERT_TRUE(M::ray_from_plane(example.shape.data(), plane.data(), again.data())) << ray.transpose();
      EXPECT_LT((again - ray).norm(), 1e-12) << ray.transpose();  // the models' promise
      EXPECT_NEAR(again.norm(), 1.0, 1e-14);
    }
  }
}

TYPED_TEST(ModelLaws, PixelToRayToPixel) {
  using M = TypeParam;
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    int valid = 0;
    for (double u = 0; u < camera.size.width; u += 61.3) {
      for (double v = 0; v < camera.size.height; v += 53.7) {
        const std::optional<Vector3d> ray = ray_from_pixel(camera, {u, v});
        if (!ray || std::acos(std::min(1.0, ray->z())) > example.half_angle_rad) continue;
        ++valid;
        const std::optional<Vector2d> pixel = pixel_from_ray(camera, *ray);
        ASSERT_TRUE(pixel.has_value());
        // 1e-12 of a coordinate that is about 1000 px
        EXPECT_LT((*pixel - Vector2d(u, v)).norm(), 1e-9) << u << " " << v;
      }
    }
    EXPECT_GT(valid, 50);
  }
}

TYPED_TEST(ModelLaws, LengthOfTheRayDoesNotMatter) {
  using M = TypeParam;
  const auto& example = M::kExamples[0];
  for (const Vector3d& ray : rays_up_to(example.half_angle_rad)) {
    Vector2d plane;
    ASSERT_TRUE(M::plane_from_ray(example.shape.data(), ray.data(), plane.data()));
    for (const double length : {1e-3, 0.7, 123.0}) {
      const Vector3d scaled = length * ray;
      Vector2d plane_of_scaled;
      ASSERT_TRUE(M::plane_from_ray(example.shape.data(), scaled.data(), plane_of_scaled.data()));
      EXPECT_LT((plane_of_scaled - plane).norm(), 1e-13 * (1 + plane.norm()));
    }
  }
}

TYPED_TEST(ModelLaws, RadiusGrowsUpToTheMaximalAngleAndNotBeyond) {
  using M = TypeParam;
  for (const auto& example : M::kExamples) {
    std::array<double, kShapeSize<M>> shape = example.shape;
    for (int k = 0; k < kShapeSize<M>; ++k) {  // the law is about the radial profile: no decentring, no prism
      if (M::kShapeNames[k][0] == 'p' || M::kShapeNames[k][0] == 's') shape[k] = 0.0;
    }
    const double limit = M::max_angle_rad(shape.data());
    ASSERT_GT(limit, example.half_angle_rad);
    ASSERT_LE(limit, M_PI);
    double last = -1.0;
    for (int i = 0; i <= 1000; ++i) {
      const Vector3d ray = ray_at(limit * (1 - 1e-6) * i / 1000, 0.3);
      Vector2d plane;
      ASSERT_TRUE(M::plane_from_ray(shape.data(), ray.data(), plane.data())) << i;
      ASSERT_GT(plane.norm(), last) << i;
      last = plane.norm();
    }
    const double beyond = limit + 1e-3;
    if (beyond >= M_PI) continue;
    Vector2d plane;
    if (!M::plane_from_ray(shape.data(), ray_at(beyond, 0.3).data(), plane.data())) continue;
    Vector2d further;
    ASSERT_TRUE(M::plane_from_ray(shape.data(), ray_at(beyond + 1e-3, 0.3).data(), further.data()));
    EXPECT_LT(further.norm(), plane.norm());  // it has folded back
  }
}

TYPED_TEST(ModelLaws, NeverReturnsARayFromBeyondTheFold) {
  using M = TypeParam;
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    const double limit = max_angle_rad(camera);
    for (double azimuth = 0; azimuth < 6.2; azimuth += 0.37) {
      for (double angle = limit + 0.002; angle < M_PI; angle += 0.1) {
        const Vector3d ray = ray_at(angle, azimuth);
        EXPECT_FALSE(pixel_from_ray(camera, ray).has_value());
        Vector2d plane;
        if (!M::plane_from_ray(example.shape.data(), ray.data(), plane.data())) continue;
        Vector3d again;
        if (!M::ray_from_plane(example.shape.data(), plane.data(), again.data())) continue;
        EXPECT_LE(std::atan2(again.head<2>().norm(), again.z()), limit + 1e-9);
      }
    }
  }
}

TYPED_TEST(ModelLaws, RefusesRaysBehindUnlessTheModelReachesThem) {
  using M = TypeParam;
  const auto& example = M::kExamples[0];
  const Vector3d backwards(0, 0, -1);
  Vector2d plane;
  EXPECT_FALSE(M::plane_from_ray(example.shape.data(), backwards.data(), plane.data()));
  const double limit = M::max_angle_rad(example.shape.data());
  if (limit > M_PI_2) {
    EXPECT_TRUE(M::plane_from_ray(example.shape.data(), ray_at(0.5 * (M_PI_2 + limit), 1).data(), plane.data()));
  } else {
    EXPECT_FALSE(M::plane_from_ray(example.shape.data(), ray_at(M_PI_2 + 0.01, 1).data(), plane.data()));
  }
}

TYPED_TEST(ModelLaws, StartCameraHasTheFocalLengthThatWasAskedFor) {
  using M = TypeParam;
  const Camera camera = start_camera(*model_named(M::kName), {640, 480}, 300.0);
  const std::optional<Vector2d> on_axis = pixel_from_ray(camera, {0, 0, 1});
  ASSERT_TRUE(on_axis.has_value());
  EXPECT_NEAR((*on_axis - Vector2d(319.5, 239.5)).norm(), 0.0, 1e-12);
  const std::optional<Vector2d> near_axis = pixel_from_ray(camera, ray_at(1e-4, 0));
  ASSERT_TRUE(near_axis.has_value());
  EXPECT_NEAR((near_axis->x() - 319.5) / 1e-4, 300.0, 1e-4);  // the next term of the profile is of the order 1e-8
  EXPECT_NEAR(focal_on_axis_px(camera), 300.0, 1e-3);         // here of 1e-6
  EXPECT_TRUE(pixel_from_ray(camera, ray_at(0.8, 2)).has_value());
}

TYPED_TEST(ModelLaws, NotANumberNeverBecomesANumber) {
  using M = TypeParam;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto& example = M::kExamples[0];
  for (int i = 0; i < 3; ++i) {
    Vector3d ray = ray_at(0.4, 0.6);
    ray[i] = kNan;
    Vector2d plane(0, 0);
    EXPECT_TRUE(!M::plane_from_ray(example.shape.data(), ray.data(), plane.data()) || !plane.allFinite());
  }
  for (int i = 0; i < 2; ++i) {
    Vector2d plane(0.1, 0.2);
    plane[i] = kNan;
    Vector3d ray(0, 0, 0);
    EXPECT_TRUE(!M::ray_from_plane(example.shape.data(), plane.data(), ray.data()) || !ray.allFinite());
  }
  for (int k = 0; k < kShapeSize<M>; ++k) {
    std::array<double, kShapeSize<M>> shape = example.shape;
    shape[k] = kNan;
    Vector2d plane(0, 0);
    EXPECT_TRUE(!M::plane_from_ray(shape.data(), ray_at(0.4, 0.6).data(), plane.data()) || !plane.allFinite());
    Vector3d ray(0, 0, 0);
    plane = {0.1, 0.2};
    EXPECT_TRUE(!M::ray_from_plane(shape.data(), plane.data(), ray.data()) || !ray.allFinite());
    M::max_angle_rad(shape.data());  // any answer; it must come back
  }
}

TYPED_TEST(ModelLaws, HugePixelsAreRefusedOrHaveAUnitRay) {
  using M = TypeParam;
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    for (const double size : {1e5, 1e9, 1e15, 1e153, 1e200, 1e300, std::numeric_limits<double>::infinity()}) {
      const std::optional<Vector3d> ray = ray_from_pixel(camera, {size, -0.3 * size});
      EXPECT_NEAR(ray ? ray->norm() : 1.0, 1.0, 1e-9) << size;
    }
  }
}

}  // namespace
}  // namespace raybundle
